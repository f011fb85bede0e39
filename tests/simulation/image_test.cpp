// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/rendering/image.hpp"

#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>
#include <zlib.h>

#include <cmath>
#include <string>
#include <string_view>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::simulation {
namespace {

constexpr int kWidth = 20, kHeight = 10;

Image plain(std::uint8_t level) {
  return {kWidth, kHeight, std::vector<std::uint8_t>(3 * kWidth * kHeight, level)};
}

struct Chunk {
  std::string type, data;
  bool sound;  // its checksum is right
};

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return value;
}

std::vector<Chunk> chunks_of(const std::string& png) {
  std::vector<Chunk> chunks;
  for (std::size_t at = 8; at + 12 <= png.size();) {
    const std::size_t length = number_at(png, at);
    const std::string checked = png.substr(at + 4, 4 + length);
    const auto sum =
        crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()));
    chunks.push_back(
        {checked.substr(0, 4), checked.substr(4), sum == number_at(png, at + 8 + length)});
    at += 12 + length;
  }
  return chunks;
}

/// Rows of pixels, each after the byte of its filter.
std::vector<Bytef> unpacked(const std::string& compressed) {
  std::vector<Bytef> rows(100000);
  uLongf size = rows.size();
  EXPECT_EQ(uncompress(rows.data(), &size, reinterpret_cast<const Bytef*>(compressed.data()),
                       static_cast<uLong>(compressed.size())),
            Z_OK);
  rows.resize(size);
  return rows;
}

class Animation : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path); }
  std::filesystem::path path = std::filesystem::temp_directory_path() /
                               ("palpate-animation-" + std::to_string(getpid()) + ".png");
};

TEST_F(Animation, StoresWhatChanges) {
  std::vector<Image> images(3, plain(10));
  images[1].rgb[3 * (4 * kWidth + 7)] = 200;  // row 4, column 7
  images[1].rgb[3 * (6 * kWidth + 9)] = 200;
  images[2] = images[1];
  save_animation(path, images, 0.25);
  const auto chunks = chunks_of(read_file(path));
  std::string order;
  for (const Chunk& chunk : chunks) {
    order += chunk.type + " ";
    EXPECT_TRUE(chunk.sound) << chunk.type;
  }
  EXPECT_EQ(order, "IHDR acTL tRNS fcTL IDAT fcTL fdAT fcTL fdAT IEND ");
  EXPECT_EQ(number_at(chunks[1].data, 0), 3u);
  const auto rectangle = [&](std::size_t chunk) {
    std::vector<std::uint32_t> numbers;
    for (std::size_t at = 0; at <= 16; at += 4) {
      numbers.push_back(number_at(chunks[chunk].data, at));
    }
    return numbers;  // sequence, width, height, x, y
  };
  EXPECT_EQ(rectangle(3), (std::vector<std::uint32_t>{0, kWidth, kHeight, 0, 0}));
  EXPECT_EQ(rectangle(5), (std::vector<std::uint32_t>{1, 3, 3, 7, 4}));
  EXPECT_EQ(rectangle(7), (std::vector<std::uint32_t>{3, 1, 1, 0, 0}));
  EXPECT_EQ(number_at(chunks[5].data, 20), 250u << 16 | 1000u);  // ms
  EXPECT_EQ(number_at(chunks[6].data, 0), 2u);
  EXPECT_EQ(unpacked(chunks[6].data.substr(4)).size(), 3u * (1 + 3 * 3));
}

TEST_F(Animation, LeavesOutWhatStaysAsItWas) {
  std::vector<Image> images(2, plain(8));
  images[1].rgb[3 * (4 * kWidth + 7)] = 203;
  images[1].rgb[3 * (4 * kWidth + 9)] = 203;
  save_animation(path, images, 0.25);
  const auto chunks = chunks_of(read_file(path));
  EXPECT_EQ(chunks[2].data, std::string("\0\xff\0\0\0\xff", 6));   // magenta is transparent
  EXPECT_EQ(chunks[5].data.substr(24), std::string("\0\x01", 2));  // and lies over the first
  const auto row = unpacked(chunks[6].data.substr(4));
  ASSERT_EQ(row.size(), 1u + 3 * 3);
  ASSERT_NE(row[0], 3);  // PNG's filter of averages, which this does not read
  const bool left = row[0] == 1 || row[0] == 4;  // the pixel before is added; above there is none
  const auto level = [&](std::size_t i) {
    int sum = row[1 + i];
    for (std::size_t k = i; left && k >= 3; k -= 3) sum += row[1 + k - 3];
    return sum % 256;
  };
  const int expected[] = {200, 8, 8, 255, 0, 255, 200, 8, 8};
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(level(i), expected[i]) << i;
}

TEST_F(Animation, ShowsItsFirstPictureToOtherPrograms) {
  save_animation(path, {plain(40), plain(90)}, 0.1);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&header, path.c_str()));
  header.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(header));
  ASSERT_TRUE(png_image_finish_read(&header, nullptr, pixels.data(), 0, nullptr));
  EXPECT_EQ(pixels, plain(40).rgb);
}

TEST_F(Animation, RefusesBadInput) {
  EXPECT_THROW(save_animation(path, {}, 0.1), BadInput);
  EXPECT_THROW(
      save_animation(path, {plain(1), {kWidth, 1, std::vector<std::uint8_t>(3 * kWidth)}}, 0.1),
      BadInput);
  EXPECT_THROW(save_animation(path, {{2, 2, {1, 2, 3}}}, 0.1), BadInput);
  for (const double seconds : {0.0, -1.0, 61.0, std::nan("")}) {
    EXPECT_THROW(save_animation(path, {plain(1)}, seconds), BadInput) << seconds;
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace palpate::simulation
