// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/derive_postures.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "palpate/core/gravity.hpp"
#include "palpate/grasping/grasp_plan.hpp"
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

/// Three fingers round a palm, each of which turns, and closes towards its middle.
std::string radial_hand() {
  std::string fingers, actuators;
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * std::numbers::pi * i / 3;
    fingers += fmt::format(
        R"(<body name="f{0}" pos="{1} {2} 0.02" euler="0 0 {3}">
             <joint name="f{0}_turn" axis="0 0 1" range="-0.5 0.5"/>
             <geom type="capsule" size="0.01" fromto="0 0 0 0 0 0.02"/>
             <body pos="0 0 0.025"><joint name="f{0}_near" axis="0 -1 0" range="-1.5 1.5"/>
               <geom type="capsule" size="0.01" fromto="0 0 0 0 0 0.06"/>
               <body pos="0 0 0.065"><joint name="f{0}_far" axis="0 -1 0" range="-1.5 1.5"/>
                 <geom type="capsule" size="0.012" fromto="0 0 0 0 0 0.05"/></body></body></body>)",
        i, 0.05 * std::cos(angle), 0.05 * std::sin(angle), angle);
    for (const char* joint : {"turn", "near", "far"}) {
      actuators += fmt::format(R"(<position joint="f{}_{}" kp="4"/>)", i, joint);
    }
  }
  return fmt::format(
      R"(<mujoco><compiler angle="radian" autolimits="true"/>
         <default><position inheritrange="1" forcerange="-2 2"/></default>
         <worldbody><body name="palm"><geom type="cylinder" size="0.05 0.02"/>{}</body></worldbody>
         <actuator>{}</actuator></mujoco>)",
      fingers, actuators);
}

/// Cost of the best grasp of an object that stands or lies over the origin.
double best_cost(const hand::Description& hand, const geometry::ObjectModel& object,
                 const Eigen::Isometry3d& T_world_object) {
  const hand::Preshape& preshape = hand.postures.top;
  const auto path = closing_trajectory(hand, preshape.open, ClosingLaw(hand, 1, preshape.closed));
  GraspPlanOptions options;
  options.press = 4.5 * kGravity * object.object().mass;  // as a pick does
  const auto plan = plan_grasp(object, T_world_object, path, preshape.attitudes.front(), options);
  return plan ? plan->cost : std::numeric_limits<double>::infinity();
}

TEST(DerivePostures, ARadialHandHoldsWhatIsLongAndLies) {
  hand::Description hand =
      simulation::describe_hand(simulation::write_hand("radial.xml", radial_hand())).hand;
  derive_postures(hand);
  const geometry::ObjectModel bottle(geometry::load_known_object("bottle"));
  for (const geometry::StablePose& stable_pose : bottle.object().stable_poses) {
    if (stable_pose.probability < 0.1) continue;
    Eigen::Isometry3d T(stable_pose.R_table_object);
    T.translation().z() = stable_pose.height;
    EXPECT_LT(best_cost(hand, bottle, T), 0.05) << "stands or lies at " << stable_pose.height;
  }
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
