// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace palpate::simulation {

/// A picture: width x height pixels of three bytes (red, green, blue), row by row from the top
/// left.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

/// Writes a picture as a PNG file.
/// @throws BadInput if the picture is empty or its bytes do not fit its size, or if the file cannot
///         be written
void save_png(const std::filesystem::path& path, const Image& image);

}  // namespace palpate::simulation
