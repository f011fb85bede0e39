// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "common.hpp"
#include "palpate/evaluation/trial.hpp"
#include "trial_records.hpp"
#include "trials_file.hpp"

namespace palpate::app {

/// What an evaluation keeps in its folder, from which it goes on where it was interrupted.
class EvalOutput {
 public:
  /// @param shard  the share of the trials, as I/N
  /// @throws BadInput if the folder is of another evaluation, and not --force
  EvalOutput(const CommonOptions& common, const evaluation::TrialOptions& options,
             const EvalPlan& plan, const std::string& shard);

  /// A trial that was finished before.
  std::optional<evaluation::Trial> find(const std::string& object, std::uint64_t seed) const {
    return records_.find(object, seed);
  }
  void add(const std::string& object, std::uint64_t seed, const evaluation::Trial& trial);
  /// All trials have ended. @param summary  of them, for eval.json
  void finish(const nlohmann::json& summary);

 private:
  std::filesystem::path begin() const;

  OutputFolder folder_;
  TrialRecords records_;
  TrialsFile table_;
};

}  // namespace palpate::app
