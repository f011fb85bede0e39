// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/rendering/renderer.hpp"

#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <set>
#include <thread>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "simulation/scenes.hpp"

namespace palpate::simulation {
namespace {

constexpr int kWidth = 160, kHeight = 120;

/// The hand over a block.
DrawnState hovering() {
  DrawnState state;
  state.joints.setZero(hand::kShadowJoints);
  state.T_world_object.translation() << 0, 0, 0.03;
  state.mount.xyz << 0, 0, 0.2;
  return state;
}

std::size_t different_pixels(const Image& a, const Image& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.rgb.size(); i += 3) {
    count += !std::equal(a.rgb.begin() + static_cast<std::ptrdiff_t>(i),
                         a.rgb.begin() + static_cast<std::ptrdiff_t>(i + 3),
                         b.rgb.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return count;
}

class Drawing : public testing::Test {
 protected:
  void SetUp() override {
    if (!working_render_backend()) GTEST_SKIP() << "neither EGL nor OSMesa works here";
    renderer.emplace(hand_, block(), kWidth, kHeight);
  }

  const hand::Description hand_ = load_hand("shadow");
  std::optional<Renderer> renderer;
};

TEST_F(Drawing, ShowsMoreThanOneColor) {
  const Image image = renderer->render(hovering());
  ASSERT_EQ(image.width, kWidth);
  ASSERT_EQ(image.height, kHeight);
  ASSERT_EQ(image.rgb.size(), 3u * kWidth * kHeight);
  EXPECT_GT(std::set<std::uint8_t>(image.rgb.begin(), image.rgb.end()).size(), 50u);
}

TEST_F(Drawing, ShowsTheSkyAboveTheTable) {
  Camera level;
  level.elevation_deg = -5;
  const Image image = renderer->render(hovering(), level);
  const auto last_row = image.rgb.end() - 3 * kWidth;
  const auto blueness = [](auto pixel) { return pixel[2] - pixel[0]; };
  EXPECT_GT(blueness(image.rgb.begin()), blueness(last_row));
}

TEST_F(Drawing, ShowsWhereTheObjectIs) {
  DrawnState state = hovering();
  const Image before = renderer->render(state);
  state.T_world_object.translation().x() += 0.03;
  EXPECT_GT(different_pixels(before, renderer->render(state)), 100u);
}

TEST_F(Drawing, ShowsHowTheHandIsHeld) {
  DrawnState state = hovering();
  const Image open = renderer->render(state);
  for (const char* joint : {"FFJ3", "MFJ3", "RFJ3", "LFJ3"}) {
    state.joints[hand::shadow_hand().joint(joint)] = 1.3;
  }
  const Image bent = renderer->render(state);
  EXPECT_GT(different_pixels(open, bent), 50u);
  state.mount.ypr.z() = std::numbers::pi / 2;
  EXPECT_GT(different_pixels(bent, renderer->render(state)), 50u);
}

TEST_F(Drawing, ShowsTheSameTwice) {
  const Image image = renderer->render(hovering());
  DrawnState elsewhere = hovering();
  elsewhere.mount.xyz.z() = 0.4;
  renderer->render(elsewhere);
  EXPECT_EQ(image.rgb, renderer->render(hovering()).rgb);
  EXPECT_EQ(image.rgb, Renderer(hand_, block(), kWidth, kHeight).render(hovering()).rgb);
}

TEST_F(Drawing, WorksInAnyThread) {
  const Image here = renderer->render(hovering());
  Image there;
  std::thread([&] { there = renderer->render(hovering()); }).join();
  EXPECT_EQ(here.rgb, there.rgb);
}

TEST_F(Drawing, RefusesWhatIsNotFinite) {
  DrawnState state = hovering();
  state.joints[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(renderer->render(state), BadInput);
  Camera camera;
  camera.distance = 0;
  EXPECT_THROW(renderer->render(hovering(), camera), BadInput);
}

TEST(Renderer, RefusesASizeThatIsNoPicture) {
  EXPECT_THROW(Renderer(load_hand("shadow"), block(), 0, 100), BadInput);
  EXPECT_THROW(Renderer(load_hand("shadow"), block(), 100, 100000), BadInput);
}

TEST(Renderer, TheWorkingBackendDoesNotChange) {
  EXPECT_EQ(working_render_backend(), working_render_backend());
}

/// Path of a file that is gone after the test.
class Png : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path); }

  const std::filesystem::path path = std::filesystem::temp_directory_path() /
                                     ("palpate-image-" + std::to_string(getpid()) + ".png");
};

TEST_F(Png, KeepsEveryPixel) {
  Image image{3, 2, {}};
  for (int i = 0; i < 18; ++i) image.rgb.push_back(static_cast<std::uint8_t>(14 * i));
  save_png(path, image);

  const std::string bytes = read_file(path);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()));
  EXPECT_EQ(header.width, 3u);
  EXPECT_EQ(header.height, 2u);
  header.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> read(PNG_IMAGE_SIZE(header));
  ASSERT_TRUE(png_image_finish_read(&header, nullptr, read.data(), 0, nullptr));
  EXPECT_EQ(read, image.rgb);
}

TEST_F(Png, RefusesAPictureWithoutItsPixels) {
  EXPECT_THROW(save_png(path, {}), BadInput);
  EXPECT_THROW(save_png(path, {2, 2, {1, 2, 3}}), BadInput);
  EXPECT_THROW(save_png(path, {-1, -1, {1, 2, 3}}), BadInput);
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace palpate::simulation
