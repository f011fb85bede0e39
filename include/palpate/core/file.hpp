// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace palpate {

/// Writes a file under a temporary name (PATH.partial) and renames it, so that nobody ever sees
/// half of it. Parent folders are made.
/// @throws BadInput, naming the path, if it cannot be written; nothing is left behind
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

/// Whole content of a file.
/// @throws BadInput, naming the path, if it is missing, a folder, or cannot be read
std::string read_file(const std::filesystem::path& path);

/// Makes a folder (and its parents) and checks that files can be written into it.
/// @throws BadInput, naming the path, if not
void make_writable_folder(const std::filesystem::path& path);

}  // namespace palpate
