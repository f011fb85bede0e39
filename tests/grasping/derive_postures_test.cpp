// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/derive_postures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/hand/hand.hpp"
#include "palpate/hand/self_clearance.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"
#include "simulation/hand_files.hpp"

namespace palpate::grasping {
namespace {

/// A hand of two fingers and a thumb with its postures: searched for once, as that takes seconds.
const hand::Description& derived() {
  static const hand::Description hand = [] {
    auto described =
        simulation::describe_hand(simulation::write_hand("derived.xml", simulation::kHandMjcf))
            .hand;
    derive_postures(described);
    return described;
  }();
  return hand;
}

/// Height of the lowest ball of a link, or of all others, over the mount, m.
double lowest(const hand::PointingHand& pointing, bool of_tip) {
  const hand::Description& hand = derived();
  hand::MountPosition mount;
  mount.ypr << 0, pointing.attitude.pitch, pointing.attitude.roll;
  const auto T =
      hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, pointing.positions));
  const int tip = hand.fingers[static_cast<std::size_t>(pointing.finger)].link;
  double low = std::numeric_limits<double>::infinity();
  for (const auto& ball : hand.spheres) {
    if ((ball.link == tip) != of_tip) continue;
    const Eigen::Vector3d p = mount.pose() * (T[static_cast<std::size_t>(ball.link)] * ball.center);
    low = std::min(low, p.z() - ball.radius);
  }
  return low;
}

TEST(DerivePostures, EveryPostureIsWithinTheRangesOfTheHand) {
  const hand::Description& hand = derived();
  const hand::Postures& postures = hand.postures;
  for (const auto* posture : {&postures.top.open, &postures.top.closed, &postures.flat.positions,
                              &postures.stretched, &postures.folded}) {
    ASSERT_EQ(posture->size(), hand.actuator_count());
    for (int i = 0; i < hand.actuator_count(); ++i) {
      const auto& [low, high] = hand.actuators[static_cast<std::size_t>(i)].command;
      EXPECT_GE((*posture)[i], low);
      EXPECT_LE((*posture)[i], high);
    }
  }
}

TEST(DerivePostures, ClosingMovesEveryFingerAndItsThumb) {
  const hand::Description& hand = derived();
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    double way = 0;
    for (const int i : hand::closing_actuators(hand, finger)) {
      way += std::abs(hand.postures.top.closed[i] - hand.postures.top.open[i]);
    }
    EXPECT_GT(way, 0.5) << finger;
  }
}

TEST(DerivePostures, APointingFingertipIsTheLowestPart) {
  ASSERT_EQ(derived().postures.pointing.size(), 2u) << "one a finger but the thumb";
  for (const auto& pointing : derived().postures.pointing) {
    EXPECT_NE(pointing.finger, derived().thumb);
    EXPECT_LT(lowest(pointing, true), lowest(pointing, false)) << pointing.finger;
  }
}

TEST(DerivePostures, AFoldedHandDoesNotPressOnItself) {
  const hand::Description& hand = derived();
  const auto joints = [&](const auto& posture) { return joints_in_free_flexion(hand, posture); };
  EXPECT_TRUE(hand::SelfClearance(hand, joints(hand.postures.stretched))
                  .is_clear(joints(hand.postures.folded)));
}

TEST(DerivePostures, AFingerMayBeExcludedFromClosing) {
  simulation::HandNotes notes;
  notes.closing = "index_1,index_2,thumb_1,thumb_2";
  hand::Description hand =
      simulation::describe_hand(simulation::write_hand("idle.xml", simulation::kHandMjcf), notes)
          .hand;
  derive_postures(hand);
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const hand::Actuator& one = hand.actuators[static_cast<std::size_t>(i)];
    if (hand.fingers[static_cast<std::size_t>(one.finger)].name != "ring") continue;
    EXPECT_EQ(hand.postures.top.open[i], hand.postures.top.closed[i]) << one.name;
  }
}

TEST(DerivePostures, AForearmIsClearOfTheFlatHandsUnderside) {
  auto text = simulation::replaced(
      simulation::kHandMjcf, "<body name=\"palm\">",
      "<body name=\"forearm\"><geom type=\"capsule\" size=\"0.04\" fromto=\"-0.3 0 0 -0.12 0 0\"/>"
      "<body name=\"palm\"><joint name=\"wrist\" axis=\"0 1 0\" range=\"-0.3 0.3\"/>");
  text = simulation::replaced(text, "</worldbody>", "</body></worldbody>");
  hand::Description hand = simulation::describe_hand(simulation::write_hand("arm.xml", text)).hand;
  derive_postures(hand);
  ASSERT_NE(hand.palm, 0) << "the palm moves on the forearm";
  const hand::FlatHand& flat = hand.postures.flat;
  hand::MountPosition mount;
  mount.ypr << 0, flat.attitude.pitch, flat.attitude.roll;
  const auto T = hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, flat.positions));
  double forearm = std::numeric_limits<double>::infinity(), other = forearm;
  for (const auto& ball : hand.spheres) {
    const Eigen::Vector3d p = mount.pose() * (T[static_cast<std::size_t>(ball.link)] * ball.center);
    double& low = ball.link < hand.palm ? forearm : other;
    low = std::min(low, p.z() - ball.radius);
  }
  ASSERT_TRUE(std::isfinite(forearm));
  EXPECT_GT(forearm, other + 0.025);
}

TEST(DerivePostures, WhatWasFoundIsKept) {
  hand::Description again =
      simulation::describe_hand(simulation::write_hand("derived.xml", simulation::kHandMjcf)).hand;
  const hand::Description& first = derived();
  bool searched = false;
  derive_postures(again, [&](std::size_t, std::size_t) { searched = true; });
  EXPECT_FALSE(searched);
  EXPECT_EQ(again.postures.top.open, first.postures.top.open);
  EXPECT_EQ(again.postures.flat.positions, first.postures.flat.positions);
}

}  // namespace
}  // namespace palpate::grasping
