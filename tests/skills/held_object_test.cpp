// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "palpate/skills/place/place_goal.hpp"

namespace palpate::skills {
namespace {

constexpr std::size_t kLifted = 1;  // reading of the log

/// A log whose mount stood at a place when the fingers closed, and 10 cm higher when it held.
estimation::EventLog lifted_log(const hand::MountPosition& closed) {
  estimation::EventLog log;
  log.readings.resize(2);
  log.readings[0].mount = closed;
  log.readings[1].mount = closed;
  log.readings[1].mount.xyz.z() += 0.1;
  log.moments = {{estimation::TouchEvent::closed, 0}, {estimation::TouchEvent::held, 1}};
  return log;
}

TEST(HeldObject, TiltAndHeightAreTakenFromTheTable) {
  const auto box = geometry::load_known_object("box");
  const hand::MountPosition closed = {{0.02, 0.01, 0.2}, {0.7, 0.4, -0.3}};
  const Eigen::Isometry3d standing = resting_pose(box, 0, {0.03, 0.02}, 0.5);
  localization::Posterior posterior;
  for (const double tilt : {-0.1, 0.1}) {  // too far apart to agree as they are
    localization::Mode mode;
    mode.T_frame_object = standing;
    mode.T_frame_object.translation().z() += 0.1 + tilt / 10;
    mode.T_frame_object.linear() =
        Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()) * standing.linear();
    mode.weight = 0.5;
    posterior.modes.push_back(mode);
  }
  const auto held = held_object(box, posterior, lifted_log(closed), kLifted, {});
  ASSERT_TRUE(held);
  EXPECT_NEAR(held->certainty, 1, 1e-9);
  EXPECT_EQ(held->found_stable_pose, 0u);
  const Eigen::Isometry3d believed = closed.pose() * held->T_mount_object_flat;
  EXPECT_LT((believed.translation() - standing.translation()).norm(), 1e-6);
  EXPECT_LT(rotation_distance(believed.linear(), standing.linear()), 1e-6);
}

// What no mode holds agrees with nothing.
TEST(HeldObject, CertaintyIsOfTheWholePosterior) {
  const auto box = geometry::load_known_object("box");
  localization::Posterior posterior;
  localization::Mode& mode = posterior.modes.emplace_back();
  mode.T_frame_object = resting_pose(box, 0, {0.03, 0.02}, 0.5);
  mode.weight = 0.3;
  const auto held = held_object(box, posterior, lifted_log({}), kLifted, {});
  ASSERT_TRUE(held);
  EXPECT_NEAR(held->certainty, 0.3, 1e-9);
}

TEST(HeldObject, WithoutAPoseOrAnEventThereIsNone) {
  const auto box = geometry::load_known_object("box");
  EXPECT_FALSE(held_object(box, {}, lifted_log({}), kLifted, {}));
  localization::Posterior posterior;
  posterior.modes.emplace_back().weight = 1;
  EXPECT_FALSE(held_object(box, posterior, lifted_log({}), std::nullopt, {}));
  EXPECT_FALSE(held_object(box, posterior, {}, kLifted, {}));
}

}  // namespace
}  // namespace palpate::skills
