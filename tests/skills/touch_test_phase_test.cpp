// SPDX-License-Identifier: Apache-2.0
#include "skills/explore/touch_test_phase.hpp"

#include <gtest/gtest.h>

#include "hand/fake_hand.hpp"
#include "palpate/estimation/height_probe.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/hand/kinematics.hpp"
#include "skills/soft_shadow.hpp"

namespace palpate::skills {
namespace {

constexpr int kFinger = 1;

/// A hand over a bare table, which bears it wherever its lowest part would be below; the finger
/// senses that, or nothing.
struct OverTheTable {
  explicit OverTheTable(bool senses)
      : hand([senses](hand::HandReading& reading) {
          if (estimation::lowest_of_hand(soft_shadow(), reading) > 0) return;
          reading.mount_force.z() = -6;
          const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
          if (senses) reading.contacts[kFinger] = {{0.01 * up, up, -2 * up}};
        }),
        robot(hand, soft_shadow(), evaluation::waiting_command(soft_shadow())) {}

  hand::FakeHand hand;
  Executor robot;
  PickState state;
};

TEST(TouchTestPhase, AFingertipThatSensesTheTableIsCleared) {
  OverTheTable scene(true);
  scene.robot.trust().suspect(kFinger);
  ASSERT_EQ(scene.robot.trust().suspects(), std::vector<int>{kFinger});
  EXPECT_TRUE(TouchTestPhase({}).run(scene.robot, scene.state).ok);
  EXPECT_TRUE(scene.robot.trust().cleared(kFinger));
  EXPECT_TRUE(scene.robot.trust().trusted(kFinger));
  EXPECT_TRUE(scene.robot.survived().empty());
}

TEST(TouchTestPhase, AnInsensitiveFingertipIsNamedAndNoLongerBelieved) {
  OverTheTable scene(false);
  scene.robot.trust().suspect(kFinger);
  const PhaseEnd end = TouchTestPhase({}).run(scene.robot, scene.state);
  EXPECT_TRUE(end.ok);
  const std::string& name = soft_shadow().fingers[kFinger].name;
  EXPECT_NE(end.outcome.find(name), std::string::npos) << end.outcome;
  EXPECT_FALSE(scene.robot.trust().trusted(kFinger));
  ASSERT_EQ(scene.robot.survived().size(), 1U);
  EXPECT_EQ(scene.robot.survived()[0].fault, Fault::touch_lost);
}

/// The lower of two fingertips.
int lower_finger(const hand::HandReading& reading, int a, int b) {
  const auto links = hand::forward_kinematics(soft_shadow(), reading.joints);
  const Eigen::Isometry3d T_world_mount = reading.mount.pose();
  const auto height = [&](int finger) {
    const auto& tip = soft_shadow().fingers[static_cast<std::size_t>(finger)];
    return (T_world_mount * links[static_cast<std::size_t>(tip.link)].translation()).z();
  };
  return height(a) < height(b) ? a : b;
}

TEST(TouchTestPhase, FingertipsThatReportEachOthersContactsAreSwapped) {
  constexpr int kOther = 3;
  hand::FakeHand hand([](hand::HandReading& reading) {
    if (estimation::lowest_of_hand(soft_shadow(), reading) > 0) return;
    reading.mount_force.z() = -6;
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    const int reporting = lower_finger(reading, kFinger, kOther) == kFinger ? kOther : kFinger;
    reading.contacts[static_cast<std::size_t>(reporting)] = {{0.01 * up, up, -2 * up}};
  });
  Executor robot(hand, soft_shadow(), evaluation::waiting_command(soft_shadow()));
  PickState state;
  robot.trust().suspect(kFinger);
  robot.trust().suspect(kOther);
  EXPECT_EQ(TouchTestPhase({}).run(robot, state).outcome, "swapped: FF and RF");
  EXPECT_TRUE(robot.trust().suspects().empty());
  EXPECT_TRUE(robot.trust().trusted(kFinger) && robot.trust().trusted(kOther));
  ASSERT_EQ(robot.survived().size(), 1U);
  EXPECT_EQ(robot.survived()[0].fault, Fault::touch_swapped);
  robot.trust().suspect(kFinger);  // a further test finds that both sense for themselves
  EXPECT_TRUE(robot.trust().suspects().empty());
}

TEST(TouchTestPhase, AFingertipThatAnArmCannotPressOnTheTableStaysUntested) {
  struct OutOfReach : hand::FakeHand {
    hand::PathFeasibility check_path(std::span<const hand::MountPosition> way) const override {
      const bool far = way.back().xyz.head<2>().norm() > 0.2;
      return {.obstacle = far ? "out of reach" : "", .feasible = 0};
    }
  };
  OutOfReach hand;
  Executor robot(hand, soft_shadow(), evaluation::waiting_command(soft_shadow()));
  PickState state;
  robot.trust().suspect(kFinger);
  EXPECT_EQ(TouchTestPhase({}).run(robot, state).outcome, "out of reach: FF");
  EXPECT_TRUE(robot.trust().trusted(kFinger));
  EXPECT_FALSE(robot.trust().cleared(kFinger));
  EXPECT_TRUE(robot.trust().suspects().empty());
  EXPECT_TRUE(robot.survived().empty());
}

TEST(TouchTestPhase, WithoutASuspectNothingIsPressed) {
  OverTheTable scene(false);
  EXPECT_EQ(TouchTestPhase({}).run(scene.robot, scene.state).outcome,
            "all fingertips sense contact");
  for (const auto& reading : scene.robot.log().readings) {
    EXPECT_GT(estimation::lowest_of_hand(soft_shadow(), reading), 0);
  }
}

}  // namespace
}  // namespace palpate::skills
