// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

namespace palpate::learning {

/// Folder of the human sequence; none where PALPATE_DATA is unset.
inline std::optional<std::filesystem::path> human_folder() {
  const char* const data = std::getenv("PALPATE_DATA");
  if (!data) return {};
  return std::filesystem::path(data) / "human_relocate";
}

}  // namespace palpate::learning
