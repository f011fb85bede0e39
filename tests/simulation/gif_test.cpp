// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "palpate/core/file.hpp"
#include "palpate/core/random.hpp"
#include "palpate/simulation/rendering/image.hpp"

namespace palpate::simulation {
namespace {

/// Reads what GIF89a says of a file without interlacing and local colours.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {
    EXPECT_EQ(take(6), "GIF89a");
    screen_.width = take_short();
    screen_.height = take_short();
    EXPECT_EQ(take(3), std::string("\xf7\0\0", 3));
    colors_ = take(std::size_t{3} * 256);
    screen_.rgb.resize(3 * static_cast<std::size_t>(screen_.width * screen_.height));
    while (read_block()) {
    }
    EXPECT_EQ(at_, file_.size());
  }

  std::vector<Image> shown;
  std::vector<int> delays;

 private:
  std::string take(std::size_t count) {
    at_ += count;
    return file_.substr(at_ - count, count);
  }
  int take_byte() { return static_cast<std::uint8_t>(take(1)[0]); }
  int take_short() {
    const int low = take_byte();
    return low | take_byte() << 8;
  }
  std::string take_blocks() {
    std::string all;
    while (const int size = take_byte()) all += take(static_cast<std::size_t>(size));
    return all;
  }

  bool read_block() {
    const int kind = take_byte();
    if (kind == 0x21) {
      const int label = take_byte();
      const std::string data = take_blocks();
      if (label == 0xf9) {
        delays.push_back(static_cast<std::uint8_t>(data[1]) | static_cast<std::uint8_t>(data[2])
                                                                  << 8);
        transparent_ = static_cast<std::uint8_t>(data[3]);
      }
      return true;
    }
    if (kind == 0x2c) draw();
    return kind == 0x2c;
  }

  void draw() {
    const int left = take_short(), top = take_short(), width = take_short(), height = take_short();
    EXPECT_EQ(take_byte(), 0);
    const int bits = take_byte();
    const auto pixels = unpacked(take_blocks(), bits);
    ASSERT_EQ(pixels.size(), static_cast<std::size_t>(width * height));
    for (int i = 0; i < width * height; ++i) {
      const int index = pixels[static_cast<std::size_t>(i)];
      if (index == transparent_) continue;
      const int at = (top + i / width) * screen_.width + left + i % width;
      for (std::size_t c = 0; c < 3; ++c) {
        screen_.rgb[3 * static_cast<std::size_t>(at) + c] =
            static_cast<std::uint8_t>(colors_[3 * static_cast<std::size_t>(index) + c]);
      }
    }
    shown.push_back(screen_);
  }

  static std::vector<int> unpacked(const std::string& bytes, int bits) {
    const int clear = 1 << bits;
    std::vector<std::vector<int>> texts;
    std::vector<int> result, before;
    int width = bits + 1;
    const auto forget = [&] {
      texts.assign(static_cast<std::size_t>(clear) + 2, {});
      for (int i = 0; i < clear; ++i) texts[static_cast<std::size_t>(i)] = {i};
      width = bits + 1;
      before.clear();
    };
    for (std::size_t at = 0; at + static_cast<std::size_t>(width) <= 8 * bytes.size();) {
      int code = 0;
      for (int k = 0; k < width; ++k, ++at) {
        code |= (static_cast<std::uint8_t>(bytes[at / 8]) >> (at % 8) & 1) << k;
      }
      if (code == clear + 1) return result;
      if (code == clear) {
        forget();
        continue;
      }
      const bool known = static_cast<std::size_t>(code) < texts.size();
      EXPECT_TRUE(known || (static_cast<std::size_t>(code) == texts.size() && !before.empty()));
      std::vector<int> text = known ? texts[static_cast<std::size_t>(code)] : before;
      if (!known) text.push_back(before[0]);
      result.insert(result.end(), text.begin(), text.end());
      if (!before.empty() && texts.size() < 4096) {
        before.push_back(text[0]);
        texts.push_back(before);
      }
      if (texts.size() == std::size_t{1} << width && width < 12) ++width;
      before = std::move(text);
    }
    ADD_FAILURE() << "no end of a picture";
    return result;
  }

  std::string file_, colors_;
  std::size_t at_ = 0;
  Image screen_;
  int transparent_ = -1;
};

class Gif : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path); }

  Reader written(const std::vector<Image>& images, double seconds) {
    save_animation(path, images, seconds);
    return Reader(read_file(path));
  }

  /// Pixels of some levels of grey, at random.
  static Image noise(int width, int height, int levels, int seed) {
    RandomStream random(static_cast<std::uint64_t>(seed), "noise");
    Image image{width, height, {}};
    for (int i = 0; i < width * height; ++i) {
      const auto level =
          static_cast<std::uint8_t>(4 * random.index(static_cast<std::size_t>(levels)));
      image.rgb.insert(image.rgb.end(), 3, level);
    }
    return image;
  }

  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("palpate-gif-" + std::to_string(getpid()) + ".gif");
};

TEST_F(Gif, FewColorsComeBackAsTheyWere) {
  std::vector<Image> images;
  for (const int levels : {64, 2, 1, 40, 40}) {
    images.push_back(noise(150, 120, levels, levels));  // fills the table of texts more than once
  }
  const Reader reader = written(images, 0.25);
  ASSERT_EQ(reader.shown.size(), images.size());
  for (std::size_t i = 0; i < images.size(); ++i)
    EXPECT_EQ(reader.shown[i].rgb, images[i].rgb) << i;
  EXPECT_EQ(reader.delays, std::vector<int>(images.size(), 25));
}

TEST_F(Gif, EveryLengthEndsAsItMust) {
  for (int width = 1; width < 300; ++width) {  // the last code falls on every step of the widths
    const Image image = noise(width, 1, 64, width);
    EXPECT_EQ(written({image}, 0.1).shown.at(0).rgb, image.rgb) << width;
  }
}

TEST_F(Gif, ManyColorsComeBackNearly) {
  Image image{256, 64, {}};
  for (int i = 0; i < 256 * 64; ++i) {
    for (const int level : {i % 256, i / 64, 255 - i % 256}) {
      image.rgb.push_back(static_cast<std::uint8_t>(level));
    }
  }
  const Reader reader = written({image}, 0.1);
  double squares = 0;
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    const double off = reader.shown.at(0).rgb[i] - image.rgb[i];
    squares += off * off / static_cast<double>(image.rgb.size());
  }
  EXPECT_LT(squares, 10 * 10);  // 255 boxes of a plane of 256 x 256 levels are 16 wide
}

TEST_F(Gif, WhatStaysAsItWasTakesNoRoom) {
  const Image image = noise(100, 100, 60, 1);
  save_animation(path, {image}, 0.1);
  const auto one = std::filesystem::file_size(path);
  save_animation(path, {image, image, image}, 0.1);
  EXPECT_LT(std::filesystem::file_size(path), one + 60);
}

}  // namespace
}  // namespace palpate::simulation
