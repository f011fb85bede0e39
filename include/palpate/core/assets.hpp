// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace palpate {

/// Path of a file that ships beside the program (hand models, viewer): under $PALPATE_ASSETS
/// if set, else where the build found it.
/// @throws BadInput, naming the path and how to get it, if it does not exist
std::filesystem::path asset(std::string_view relative_path);

}  // namespace palpate
