// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace palpate {

/// Writes a file under a temporary name (PATH.partial) and renames it, so that nobody ever sees
/// half of it, and returns when it is on the disk. Parent folders are made. Of a link, what it
/// leads to is replaced.
/// @throws BadInput, with the path and the reason, if it cannot be written, or is a device or a
///         pipe; no half of it is left behind, and what bore the name before is whole
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

/// Whole content of a file.
/// @throws BadInput, naming the path, if it is missing, a folder, cannot be read, or has more than
///         1 GiB
std::string read_file(const std::filesystem::path& path);

/// Makes a folder (and its parents) and checks that files can be written into it.
/// @throws BadInput, naming the path, if not
void make_writable_folder(const std::filesystem::path& path);

}  // namespace palpate
