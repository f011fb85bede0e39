// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/assets.hpp"

#include <fmt/format.h>

#include <cstdlib>

#include "palpate/core/error.hpp"

namespace palpate {

std::filesystem::path asset(std::string_view relative_path) {
  const char* chosen = std::getenv("PALPATE_ASSETS");
  const bool named = chosen && *chosen != '\0';
  const auto path = std::filesystem::path(named ? chosen : PALPATE_ASSETS_DIR) / relative_path;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    throw BadInput(
        fmt::format("{} is missing: run ./dev build, or set PALPATE_ASSETS to the folder "
                    "that holds {}",
                    path.string(), relative_path));
  }
  return path;
}

}  // namespace palpate
