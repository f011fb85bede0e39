// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/evaluation/trial.hpp"

namespace palpate::app {

/// Which trials an evaluation is made of, and what its summary needs to know beside them.
struct EvalPlan {
  std::vector<std::string> objects;
  std::vector<std::size_t> symmetry_orders;  ///< one an object
  std::size_t trials = 0;                    ///< of each
  std::uint64_t seed = 0;                    ///< of the first of each
  bool place = false;                        ///< they place the object
  std::string configuration;  ///< fingerprint of all else that decides how a trial goes
  std::string commit;         ///< that the program is built from
  std::vector<std::vector<std::string>> repairs;  ///< of each object's mesh, in words
  std::string repetition;                         ///< command that repeats the first trial

  /// Whether an object's trial with that seed is one of them.
  [[nodiscard]] bool has(const std::string& object, std::uint64_t trial_seed) const;
};

/// @throws BadInput, saying how, if plans differ in more than how a command is written
void expect_same_plan(const std::string& name, const EvalPlan& plan, const std::string& other_name,
                      const EvalPlan& other);

/// The finished trials of an evaluation as lines of JSON, exact, each on the disk before the next
/// ends: an evaluation that was interrupted goes on from them.
class TrialRecords {
 public:
  /// Reads what is there; half a line at the end, of a run that was killed, is dropped.
  /// @throws BadInput if the file is of another plan, or damaged
  TrialRecords(std::filesystem::path path, const EvalPlan& plan);

  /// The records of a file that is only read.
  /// @throws BadInput if there is none, or it is damaged
  static TrialRecords of(const std::filesystem::path& path);

  const EvalPlan& plan() const { return plan_; }
  /// Takes over the trials of another part of the same evaluation.
  /// @throws BadInput if it is of another plan, or a trial that is in both went otherwise there
  void add_all(const TrialRecords& other);

  /// A trial that was finished before.
  std::optional<evaluation::Trial> find(const std::string& object, std::uint64_t seed) const;

  /// Keeps a trial, unless it is there.
  /// @throws BadInput, with the reason, if it cannot be written
  void add(const std::string& object, std::uint64_t seed, const evaluation::Trial& trial);

  bool empty() const { return trials_.empty(); }

 private:
  TrialRecords() = default;
  void read(const std::string& text);

  std::filesystem::path path_;
  EvalPlan plan_;
  std::map<std::pair<std::string, std::uint64_t>, evaluation::Trial> trials_;
};

}  // namespace palpate::app
