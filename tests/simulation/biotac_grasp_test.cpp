// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "palpate/core/se3.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/world/open_loop_grasp.hpp"
#include "palpate/tactile/biotac/skin.hpp"
#include "simulation/scenes.hpp"

namespace palpate::simulation {
namespace {

/// A fingertip's contacts in the frame of a sensor along its capsule.
std::vector<hand::TipContact> contacts_of(const ObjectStep& step, int finger) {
  std::vector<hand::TipContact> contacts;
  for (const auto& contact : step.contacts) {
    if (contact.finger != finger) continue;
    const Eigen::Vector3d forward = (contact.capsule.b - contact.capsule.a).normalized();
    Eigen::Isometry3d T_world_sensor = Eigen::Isometry3d::Identity();
    const Eigen::Matrix3d frame = frame_with_z(forward);
    T_world_sensor.linear() << forward, frame.col(0), frame.col(1);
    T_world_sensor.translation() = contact.capsule.b;
    const Eigen::Matrix3d R = T_world_sensor.linear().transpose();
    const Eigen::Matrix3d& axes = contact.T_world_contact.linear();
    contacts.push_back({.p = T_world_sensor.inverse() * contact.T_world_contact.translation(),
                        .n = -(R * axes.col(0)),
                        .f = R * (axes * contact.wrench.tail<3>())});
  }
  return contacts;
}

Eigen::Vector3d total_force(const std::vector<hand::TipContact>& contacts) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& contact : contacts) sum += contact.f;
  return sum;
}

bool within_friction(const std::vector<hand::TipContact>& contacts, double friction) {
  for (const auto& contact : contacts) {
    const double pressed = -contact.f.dot(contact.n);
    if ((contact.f + pressed * contact.n).norm() > friction * pressed) return false;
  }
  return true;
}

TEST(BiotacGrasp, TaxelsCarryTheSolversForces) {
  World world(cuboid({0.12, 0.04, 0.05}, 0.2), without_noise(), 1);
  const tactile::BiotacSkin skin;
  int steps = 0, checked = 0, carried = 0;
  world.observe([&](const ObjectStep& step) {
    if (++steps % 20 != 0) return;
    for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
      const auto contacts = contacts_of(step, finger);
      const Eigen::Vector3d force = total_force(contacts);
      // A taxel cannot hold what lies at the edge of the solver's own cone.
      if (force.norm() < 0.05 || !within_friction(contacts, 0.75)) continue;
      const auto state = skin.press(contacts);
      ++checked;
      carried += (state.force - force).norm() < std::max(0.05, 0.02 * force.norm());
    }
  });
  OpenLoopGrasp grasp;
  grasp.side = false;
  grasp.height = 0.04;
  grasp.start.yaw = 0.5 * std::numbers::pi;
  EXPECT_TRUE(run_open_loop_grasp(world, grasp));
  EXPECT_GT(checked, 50);
  EXPECT_EQ(carried, checked);
}

TEST(BiotacGrasp, ReadingsHoldChannelsWhereAskedFor) {
  WorldOptions options = without_noise();
  options.biotacs = true;
  World world(block(), options, 1);
  const hand::HandCommand away = open_hand(0.5);
  world.reset({}, away);
  for (int tick = 0; tick < 30; ++tick) {
    const auto reading = world.hand().step(away);
    ASSERT_EQ(reading.biotacs.size(), static_cast<std::size_t>(hand::kShadowFingers));
    for (const auto& biotac : reading.biotacs) {
      EXPECT_EQ(biotac.time, reading.time);
      EXPECT_NEAR(biotac.pdc, 2410, 4);  // at rest, but for the noise
      EXPECT_TRUE(biotac.pac_interpolated);
    }
  }
  options.biotacs = false;
  World bare(block(), options, 1);
  bare.reset({}, away);
  EXPECT_TRUE(bare.hand().step(away).biotacs.empty());
}

TEST(BiotacGrasp, ChannelsRepeatAfterAReset) {
  WorldOptions options = without_noise();
  options.biotacs = true;
  World world(block(), options, 1);
  const hand::HandCommand away = open_hand(0.5);
  world.reset({}, away);
  const auto first = world.hand().step(away);
  world.hand().step(away);
  world.reset({}, away);
  const auto again = world.hand().step(away);
  for (std::size_t i = 0; i < first.biotacs.size(); ++i) {
    EXPECT_EQ(first.biotacs[i].electrodes, again.biotacs[i].electrodes);
    EXPECT_EQ(first.biotacs[i].pac, again.biotacs[i].pac);
  }
}

}  // namespace
}  // namespace palpate::simulation
