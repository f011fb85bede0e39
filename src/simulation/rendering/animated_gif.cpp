// SPDX-License-Identifier: Apache-2.0
#include "simulation/rendering/animated_gif.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "simulation/rendering/palette.hpp"
#include "simulation/rendering/picture_difference.hpp"

namespace palpate::simulation {
namespace {

constexpr std::uint8_t kKept = 255;  // index that leaves a pixel as it was
constexpr int kPixelBits = 8, kMostBits = 12;
constexpr std::size_t kCodes = std::size_t{1} << kMostBits;
constexpr int kClear = 1 << kPixelBits, kEnd = kClear + 1;
constexpr std::size_t kBlock = 255;  // bytes of a block, at most

using Indices = std::string;  // of colours, a byte a pixel

void append_little(std::string& bytes, int value) {
  bytes += static_cast<char>(value & 0xff);
  bytes += static_cast<char>(value >> 8 & 0xff);
}

/// Codes of a growing number of bits, the lowest first, as bytes.
class Bits {
 public:
  void add(int code, int bits) {
    pending_ |= static_cast<std::uint32_t>(code) << count_;
    for (count_ += bits; count_ >= 8; count_ -= 8, pending_ >>= 8) take_byte();
  }
  std::string finish() {
    if (count_ > 0) take_byte();
    return std::move(bytes_);
  }

 private:
  void take_byte() { bytes_ += static_cast<char>(pending_ & 0xff); }
  std::string bytes_;
  std::uint32_t pending_ = 0;
  int count_ = 0;
};

/// GIF's variant of LZW (GIF89a, appendix F).
std::string compressed(const Indices& indices) {
  Bits bits;
  std::vector<std::int16_t> longer(kCodes << kPixelBits, 0);  // code of a text and one more byte
  int next = kEnd + 1, width = kPixelBits + 1, text = -1;
  bits.add(kClear, width);
  for (const char letter : indices) {
    const auto index = static_cast<std::uint8_t>(letter);
    if (text < 0) {
      text = index;
      continue;
    }
    std::int16_t& code = longer[static_cast<std::size_t>(text << kPixelBits | index)];
    if (code > 0) {
      text = code;
      continue;
    }
    bits.add(text, width);
    code = static_cast<std::int16_t>(next++);
    if (next > 1 << width) ++width;
    if (width > kMostBits) {
      bits.add(kClear, kMostBits);
      std::ranges::fill(longer, 0);
      next = kEnd + 1;
      width = kPixelBits + 1;
    }
    text = index;
  }
  if (text >= 0) bits.add(text, width);
  if (next == 1 << width && width < kMostBits) ++width;  // as the reader, which has one more by now
  bits.add(kEnd, width);
  return bits.finish();
}

std::string in_blocks(const std::string& bytes) {
  std::string blocks;
  for (std::size_t at = 0; at < bytes.size(); at += kBlock) {
    const std::string block = bytes.substr(at, kBlock);
    blocks += static_cast<char>(block.size());
    blocks += block;
  }
  return blocks + '\0';
}

/// The head of a file: size, colours, and that it plays for ever.
std::string header(const Image& image, const Palette& palette) {
  std::string file = "GIF89a";
  append_little(file, image.width);
  append_little(file, image.height);
  file += std::string("\xf7\0\0", 3);  // 256 colours for all pictures
  for (std::size_t i = 0; i < 256; ++i) {
    const Color color = i < palette.colors().size() ? palette.colors()[i] : Color{};
    for (const std::uint8_t level : color) file += static_cast<char>(level);
  }
  return file + std::string("\x21\xff\x0bNETSCAPE2.0\x03\x01\0\0\0", 19);
}

Indices indices_of(const Image& image, const Palette& palette) {
  Indices indices;
  for (std::size_t at = 0; at + 3 <= image.rgb.size(); at += 3) {
    indices += static_cast<char>(palette.index_of(&image.rgb[at]));
  }
  return indices;
}

/// The part of a picture, with kKept where it is as in the one before, if there is one.
Indices changed_indices(const Indices& before, const Indices& now, const Rectangle& part,
                        int width) {
  Indices result;
  for (int y = part.y; y < part.y + part.height; ++y) {
    for (int x = part.x; x < part.x + part.width; ++x) {
      const auto at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(x);
      const bool same = !before.empty() && before[at] == now[at];
      result += same ? static_cast<char>(kKept) : now[at];
    }
  }
  return result;
}

std::string frame(const Indices& indices, const Rectangle& part, double seconds) {
  std::string bytes("\x21\xf9\x04\x05", 4);  // one index is transparent; the picture stays
  append_little(bytes, static_cast<int>(std::lround(100 * seconds)));
  bytes += static_cast<char>(kKept);
  bytes += std::string("\0\x2c", 2);
  for (const int number : {part.x, part.y, part.width, part.height}) append_little(bytes, number);
  bytes += '\0';
  bytes += static_cast<char>(kPixelBits);
  return bytes + in_blocks(compressed(indices));
}

}  // namespace

std::string encode_gif(const std::vector<Image>& images, double seconds) {
  const Palette palette(images, kKept);
  std::string file = header(images[0], palette);
  Indices before;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Rectangle part = i > 0 ? difference(images[i - 1], images[i])
                                 : Rectangle{0, 0, images[0].width, images[0].height};
    Indices now = indices_of(images[i], palette);
    file += frame(changed_indices(before, now, part, images[i].width), part, seconds);
    before = std::move(now);
  }
  return file + '\x3b';
}

}  // namespace palpate::simulation
