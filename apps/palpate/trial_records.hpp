// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "palpate/evaluation/trial.hpp"

namespace palpate::app {

/// The finished trials of an evaluation as lines of JSON, exact, each on the disk before the next
/// ends: an evaluation that was interrupted goes on from them.
class TrialRecords {
 public:
  /// Reads what is there; half a line at the end, of a run that was killed, is dropped.
  /// @param configuration  fingerprint of all that decides how a trial goes, but for its seed
  /// @throws BadInput if the file is of another configuration, or damaged
  TrialRecords(std::filesystem::path path, std::string configuration);

  /// A trial that was finished before.
  std::optional<evaluation::Trial> find(const std::string& object, std::uint64_t seed) const;

  /// Keeps a trial, unless it is there.
  /// @throws BadInput, with the reason, if it cannot be written
  void add(const std::string& object, std::uint64_t seed, const evaluation::Trial& trial);

  bool empty() const { return trials_.empty(); }

 private:
  void read(const std::string& text);

  std::filesystem::path path_;
  std::string configuration_;
  std::map<std::pair<std::string, std::uint64_t>, evaluation::Trial> trials_;
};

}  // namespace palpate::app
