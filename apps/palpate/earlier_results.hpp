// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

#include "palpate/core/error.hpp"

namespace palpate::app {

/// What `read()` makes of a file that an interrupted run left, to go on from it.
/// @throws BadInput for a file that is not what it should be
template <class Read>
auto read_earlier(const std::filesystem::path& path, Read&& read) {
  try {
    return read();
  } catch (const nlohmann::json::exception& problem) {
    throw BadInput(fmt::format("{}: damaged: {}", path.string(), problem.what()));
  } catch (const BadInput& problem) {
    if (std::string_view(problem.what()).starts_with(path.string())) throw;
    throw BadInput(fmt::format("{}: damaged: {}", path.string(), problem.what()));
  }
}

/// @throws BadInput unless the file is of a run with the same settings
inline void expect_same_settings(const std::filesystem::path& path, bool same) {
  if (same) return;
  throw BadInput(fmt::format(
      "{} is of an evaluation with other settings: use another --out, or --force to lose it",
      path.string()));
}

}  // namespace palpate::app
