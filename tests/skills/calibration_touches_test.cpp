// SPDX-License-Identifier: Apache-2.0
#include "skills/explore/calibration_touches.hpp"

#include <gtest/gtest.h>

#include <set>

#include "skills/motion/lowest_part.hpp"
#include "skills/soft_shadow.hpp"

namespace palpate::skills {
namespace {

TEST(CalibrationTouches, EachFingertipIsTheLowestPartOfTheHandInSome) {
  const auto touches = calibration_touches(soft_shadow(), {});
  ASSERT_EQ(touches.size(), 40);
  std::set<int> fingers;
  for (const CalibrationTouch& touch : touches) {
    fingers.insert(touch.finger);
    const int tip = soft_shadow().fingers[static_cast<std::size_t>(touch.finger)].link;
    EXPECT_EQ(lowest_part(soft_shadow(), touch.posture, touch.attitude),
              lowest_part(soft_shadow(), touch.posture, touch.attitude,
                          [tip](int link) { return link == tip; }));
  }
  EXPECT_EQ(fingers.size(), soft_shadow().fingers.size());
}

TEST(CalibrationTouches, TheNextOneIsNear) {
  const auto touches = calibration_touches(soft_shadow(), {});
  const auto turn = [](const CalibrationTouch& a, const CalibrationTouch& b) {
    return std::max({std::abs(a.attitude.pitch - b.attitude.pitch),
                     std::abs(a.attitude.roll - b.attitude.roll),
                     (a.posture - b.posture).cwiseAbs().maxCoeff()});
  };
  double next = 0, any = 0;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    if (i > 0) next += turn(touches[i - 1], touches[i]) / static_cast<double>(touches.size() - 1);
    for (const CalibrationTouch& other : touches) {
      any += turn(touches[i], other) / static_cast<double>(touches.size() * (touches.size() - 1));
    }
  }
  EXPECT_LT(next, 0.7 * any);
}

}  // namespace
}  // namespace palpate::skills
