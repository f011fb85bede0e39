// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "palpate/core/random.hpp"

namespace palpate::fuzz {

/// A loader under test.
struct Target {
  std::string name;
  std::string grammar;  ///< of the format, a file of grammars/
  std::string file;     ///< name under which an input is written
  /// Reads the file. May throw BadInput and nothing else.
  std::function<void(const std::filesystem::path& file)> load;
  /// Bytes to begin with, beside the corpus; empty where the grammar and the corpus are enough.
  std::function<std::string(const std::filesystem::path& folder)> sample = {};
  /// Makes changed bytes pass the outer checks (a seal), so that what lies within is reached.
  std::function<void(const std::filesystem::path& file, RandomStream& random)> finish = {};
  /// Bytes are changed by `finish` alone: the library that reads them crashes by itself otherwise.
  bool keep_bytes = false;
};

std::vector<Target> all_targets();

}  // namespace palpate::fuzz
