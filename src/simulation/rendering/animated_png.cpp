// SPDX-License-Identifier: Apache-2.0
#include "simulation/rendering/animated_png.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>

#include "simulation/rendering/picture_difference.hpp"

namespace palpate::simulation {
namespace {

constexpr std::size_t kSignature = 8, kHeader = 25;  // bytes of the file's signature and its IHDR

// Colours of animations have 64 levels, in steps of 4, so that this one stands for "as before".
constexpr int kLevelStep = 4;
constexpr std::array<std::uint8_t, 3> kUnchanged = {255, 0, 255};

void append(std::string& bytes, std::uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(value >> shift & 0xff);
}

void append_short(std::string& bytes, std::uint32_t value) {
  for (const int shift : {8, 0}) bytes += static_cast<char>(value >> shift & 0xff);
}

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return value;
}

void append_chunk(std::string& file, const std::string& type, const std::string& data) {
  const std::string checked = type + data;
  append(file, static_cast<std::uint32_t>(data.size()));
  file += checked;
  append(file, static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(checked.data()),
                                                static_cast<uInt>(checked.size()))));
}

/// The compressed pixels of a PNG file: the data of its IDAT chunks.
std::string pixels_of(std::string_view png) {
  std::string pixels;
  for (std::size_t at = kSignature; at + 12 <= png.size();) {
    const std::size_t length = number_at(png, at);
    if (png.substr(at + 4, 4) == "IDAT") pixels += png.substr(at + 8, length);
    at += 12 + length;
  }
  return pixels;
}

/// The rows of a picture without filters, compressed: most pixels are kUnchanged, which makes long
/// runs that a filter would break.
std::string compressed(const Image& image) {
  const auto width = 3 * static_cast<std::size_t>(image.width);
  std::string rows;
  for (std::size_t at = 0; at < image.rgb.size(); at += width) {
    rows += '\0';
    rows.append(reinterpret_cast<const char*>(image.rgb.data()) + at, width);
  }
  uLongf size = compressBound(rows.size());
  std::string result(size, '\0');
  compress2(reinterpret_cast<Bytef*>(result.data()), &size,
            reinterpret_cast<const Bytef*>(rows.data()), rows.size(), Z_BEST_COMPRESSION);
  result.resize(size);
  return result;
}

/// With colours of 64 levels.
Image rounded(Image image) {
  for (auto& level : image.rgb) level = static_cast<std::uint8_t>(level - level % kLevelStep);
  return image;
}

/// The part of a picture, with kUnchanged where it is as in the one before.
Image changed(const Image& before, const Image& image, const Rectangle& part) {
  Image result{part.width, part.height, {}};
  for (int y = part.y; y < part.y + part.height; ++y) {
    for (int x = part.x; x < part.x + part.width; ++x) {
      const auto at = 3 * (static_cast<std::ptrdiff_t>(y) * image.width + x);
      const auto pixel = image.rgb.begin() + at;
      if (std::equal(pixel, pixel + 3, before.rgb.begin() + at)) {
        result.rgb.insert(result.rgb.end(), kUnchanged.begin(), kUnchanged.end());
      } else {
        result.rgb.insert(result.rgb.end(), pixel, pixel + 3);
      }
    }
  }
  return result;
}

/// The chunk that makes kUnchanged transparent.
std::string transparency() {
  std::string data;
  for (const std::uint8_t level : kUnchanged) append_short(data, level);
  return data;
}

std::string frame_control(std::uint32_t sequence, const Rectangle& part, double seconds) {
  std::string data;
  append(data, sequence);
  for (const int number : {part.width, part.height, part.x, part.y}) {
    append(data, static_cast<std::uint32_t>(number));
  }
  append_short(data, static_cast<std::uint32_t>(std::lround(1000 * seconds)));
  append_short(data, 1000);
  data += '\0';    // leave the picture as it is, and
  data += '\x01';  // put this one over what was there
  return data;
}

}  // namespace

std::string encode_animation(const std::vector<Image>& images, double seconds) {
  Image before = rounded(images[0]);
  const std::string first = encode_png(before);
  std::string file = first.substr(0, kSignature + kHeader);
  std::string control;
  append(control, static_cast<std::uint32_t>(images.size()));
  append(control, 0);  // for ever
  append_chunk(file, "acTL", control);
  append_chunk(file, "tRNS", transparency());
  std::uint32_t sequence = 0;
  append_chunk(file, "fcTL",
               frame_control(sequence++, {0, 0, images[0].width, images[0].height}, seconds));
  append_chunk(file, "IDAT", pixels_of(first));
  for (std::size_t i = 1; i < images.size(); ++i) {
    Image next = rounded(images[i]);
    const Rectangle part = difference(before, next);
    append_chunk(file, "fcTL", frame_control(sequence++, part, seconds));
    std::string data;
    append(data, sequence++);
    append_chunk(file, "fdAT", data + compressed(changed(before, next, part)));
    before = std::move(next);
  }
  append_chunk(file, "IEND", "");
  return file;
}

}  // namespace palpate::simulation
