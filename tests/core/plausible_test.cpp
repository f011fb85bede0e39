// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/plausible.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error_message.hpp"
#include "palpate/core/options.hpp"
#include "palpate/core/random.hpp"

namespace palpate {
namespace {

TEST(Plausible, NamesWhatCannotBe) {
  EXPECT_EQ(plausible(3, 0, 3, "a mass"), 3);
  EXPECT_EQ(error_message([] { plausible(-1, 0, 1, "a radius"); }),
            "a radius of -1 is not in 0..1");
  EXPECT_NE(error_message([] { plausible(std::nan(""), 0, 1, "a radius"); }), "");
}

TEST(Plausible, ChecksEveryComponent) {
  const Eigen::Vector3d nan(0, std::nan(""), 0), huge(0, 0, 1e200);
  EXPECT_NE(error_message([&] { check_plausible(nan, kMaxForce, "a force"); }), "");
  EXPECT_EQ(error_message([&] { check_plausible(nan, kMaxForce, "a force", true); }), "");
  EXPECT_NE(error_message([&] { check_plausible(huge, kMaxForce, "a force", true); }), "");
}

TEST(Plausible, ARotationIsOneForAllRotations) {
  RandomStream random(3, "plausible");
  for (int i = 0; i < 100; ++i) {
    const Eigen::Matrix3d R = random.rotation();
    EXPECT_EQ(error_message([&] { rigid(R, "R"); }), "");
    EXPECT_NE(error_message([&] { rigid(-R, "R"); }), "");
    EXPECT_NE(error_message([&] { rigid(1.001 * R, "R"); }), "");
  }
}

TEST(Options, TomlOfAnyDepthIsRefusedAndNotFollowed) {
  std::string dots = "a", arrays = "a = ";
  for (int i = 0; i < 200000; ++i) dots += ".a";
  for (int i = 0; i < 200000; ++i) arrays += "[";
  for (const std::string& text : {dots + " = 1", "[" + dots + "]", arrays}) {
    EXPECT_NE(error_message([&] { assign_toml(text, "x.toml", {}); }).find("nests deeper"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace palpate
