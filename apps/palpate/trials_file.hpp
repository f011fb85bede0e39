// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "palpate/evaluation/trial.hpp"

namespace palpate::app {

/// A CSV file with a row for each finished trial, whole at any moment: a run that is ended early
/// keeps what it has measured.
class TrialsFile {
 public:
  /// @param place  whether the trials place the object
  TrialsFile(std::filesystem::path path, bool place);
  void add(const std::string& object, std::uint64_t seed, const evaluation::Trial& trial);
  /// Puts all rows so far on the disk.
  void write() const;

 private:
  std::filesystem::path path_;
  bool place_;
  std::string text_;
};

}  // namespace palpate::app
