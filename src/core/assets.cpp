// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/assets.hpp"

#include <fmt/format.h>

#include <cstdlib>

#include "palpate/core/error.hpp"

namespace palpate {
namespace {

/// The folder beside an installed program, of the build, of an installation where it was meant to
/// be, or of the Debian package; the first that exists.
std::filesystem::path assets_folder() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto beside = program.parent_path().parent_path() / "share/palpate/assets";
  for (const std::filesystem::path& folder : {beside, std::filesystem::path(PALPATE_BUILT_ASSETS),
                                              std::filesystem::path(PALPATE_INSTALLED_ASSETS)}) {
    if (std::filesystem::is_directory(folder, error)) return folder;
  }
  return "/usr/share/palpate/assets";
}

}  // namespace

std::filesystem::path asset(std::string_view relative_path) {
  const char* chosen = std::getenv("PALPATE_ASSETS");
  const bool named = chosen && *chosen != '\0';
  const auto path = (named ? std::filesystem::path(chosen) : assets_folder()) / relative_path;
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
