// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace palpate::recording {

/// Bytes before the HDF5 part of a recording (its "user block"). They name the format and, once the
/// recording is finished, hold a checksum of all that follows.
inline constexpr std::size_t kSealSize = 512;

/// Marks the file as begun, of a format version.
void write_open_seal(const std::filesystem::path& path, int version);

/// Marks the file as finished, with its checksum.
void write_closed_seal(const std::filesystem::path& path, int version);

struct Seal {
  int version = 0;
  bool finished = false;  ///< else it was never finished
};

/// What the seal says of a file that is intact.
/// @throws BadInput if it is missing, not a recording, of a version that is not read, or damaged
Seal check_seal(const std::filesystem::path& path);

}  // namespace palpate::recording
