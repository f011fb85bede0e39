// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace palpate {

/// A file of the made-up data, which tests/data/make.py writes.
inline std::filesystem::path made_up_data(const std::string& name) {
  return std::filesystem::path(__FILE__).parent_path() / "data" / name;
}

/// A file or folder of the real data (CONTRIBUTING.md), if PALPATE_DATA names a folder that has it.
inline std::optional<std::filesystem::path> real_data(const std::string& name) {
  const char* const folder = std::getenv("PALPATE_DATA");
  if (!folder) return {};
  std::filesystem::path path = std::filesystem::path(folder) / name;
  if (!std::filesystem::exists(path)) return {};
  return path;
}

/// The made-up file and, where it is there, the real one of the same kind.
inline std::vector<std::filesystem::path> made_up_and_real(const std::string& made_up,
                                                           const std::string& real) {
  std::vector<std::filesystem::path> files{made_up_data(made_up)};
  if (const auto file = real_data(real)) files.push_back(*file);
  return files;
}

}  // namespace palpate
