// SPDX-License-Identifier: Apache-2.0
#include "skills/place/weight_bearing.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <span>

#include "hand/fake_hand.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::skills {
namespace {

constexpr double kBoxWeight = 1.5;  // N
constexpr double kFriction = 0.4;   // of the forces that bear it
constexpr double kBoxPress = 2.0;   // N, of each fingertip

/// A hand whose fingertips all touch.
struct Pinching {
  Pinching()
      : hand([](hand::HandReading& reading) {
          for (std::size_t i = 0; i < reading.contacts.size(); ++i) {
            const Eigen::Vector3d n(0, i == 0 ? -1 : 1, 0);
            reading.contacts[i].push_back({{0, 0, 0.02}, n, -kBoxPress * n});
          }
        }),
        robot(hand, model, hand::resting_command()) {
    robot.wait(0.3);
  }
  WeightBearing bearing() const { return {robot, p_mount_object, kBoxWeight, kFriction}; }

  hand::Description model =
      hand::with_soft_actuators(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")));
  hand::FakeHand hand;
  Executor robot;
  Eigen::Vector3d p_mount_object{0.3, 0, -0.05};
};

hand::MountPosition turned(double yaw, double pitch, double roll) {
  return {Eigen::Vector3d::Zero(), {yaw, pitch, roll}};
}

TEST(WeightBearing, NothingChangesWhileGravityPullsAlike) {
  const Pinching pinching;
  const auto bearing = pinching.bearing();
  for (const double yaw : {0.0, 1.0, 3.0}) {
    const auto command = bearing.command(turned(yaw, 0, 0));
    EXPECT_LT((command - pinching.robot.command().positions).norm(), 1e-9) << yaw;
  }
}

TEST(WeightBearing, FollowsTheWeightByWhatTheStaticsAsk) {
  const Pinching pinching;
  const auto bearing = pinching.bearing();
  const auto window = std::span(pinching.robot.log().readings).last(20);
  const auto contacts = tactile::lasting_contacts(window, pinching.model, {});
  const auto joints = tactile::mean_joints(window);
  const auto torques = [&](const hand::MountPosition& mount) {
    const grasping::Load load{pinching.p_mount_object,
                              -kBoxWeight * mount.pose().linear().row(2).transpose()};
    const auto balanced = grasping::distribute_forces(contacts, kFriction, 5 * kBoxPress, load);
    return grasping::pressing_torques(pinching.model, joints, contacts, balanced.forces);
  };
  const auto mount = turned(0.3, std::numbers::pi / 2, 0.4);
  const hand::ActuatorVector change = torques(mount) - torques(turned(0, 0, 0));
  const hand::ActuatorVector commanded =
      bearing.command(mount) - pinching.robot.command().positions;
  EXPECT_GT(change.norm(), 0.01);  // N m: a weight of 1.5 N turned by a right angle
  for (int i = 0; i < hand::kShadowActuators; ++i) {
    const auto& actuator = pinching.robot.actuators()[static_cast<std::size_t>(i)];
    EXPECT_NEAR(commanded[i], change[i] / actuator.stiffness, 1e-6) << i;
  }
}

TEST(WeightBearing, WithoutTouchTheFingersStay) {
  hand::Description model =
      hand::with_soft_actuators(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")));
  hand::FakeHand hand;
  Executor robot(hand, model, hand::resting_command());
  const WeightBearing bearing(robot, {0.3, 0, 0}, kBoxWeight, kFriction);
  EXPECT_EQ(bearing.command(turned(0, 1, 1)), robot.command().positions);
}

}  // namespace
}  // namespace palpate::skills
