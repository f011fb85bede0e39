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

/// Writes pictures of one size as an animated PNG, which browsers play over and over; other
/// programs show the first (W3C, Portable Network Graphics, third edition, 2025). Of every picture
/// only the rectangle that differs from the one before is stored. A path that ends with .gif is
/// written as an animated GIF of 255 colours instead, for programs that play no other.
/// @param seconds  that each picture stays, 0.001 to 60, rounded to milliseconds (GIF: hundredths)
/// @throws BadInput for no pictures, pictures of different sizes, or as save_png
void save_animation(const std::filesystem::path& path, const std::vector<Image>& images,
                    double seconds);

}  // namespace palpate::simulation
