// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::hand {

/// A reading of a hand at rest that senses nothing: all zero.
inline HandReading resting_reading(const Description& hand = shadow_hand()) {
  HandReading reading;
  reading.joints.setZero(hand.joint_count());
  reading.torques.setZero(hand.actuator_count());
  reading.contacts.resize(hand.fingers.size());
  return reading;
}

/// The command that is all zero.
inline HandCommand resting_command(const Description& hand = shadow_hand()) {
  HandCommand command;
  command.positions.setZero(hand.actuator_count());
  return command;
}

/// A hand with actuators of 1 N m/rad and 1 N m that go far beyond any joint's range.
inline Description with_soft_actuators(Description hand = shadow_hand()) {
  for (Actuator& actuator : hand.actuators) {
    actuator.stiffness = actuator.max_torque = 1;
    actuator.command = {-1.5, 3.2};
  }
  return hand;
}

/// The Shadow hand with all fingertips alike, on one link.
inline Description shadow_on_link(int link, const TipCapsule& tip = {{0, 0, 0}, {0, 0, 0}, 0}) {
  Description hand = shadow_hand();
  for (Finger& finger : hand.fingers) {
    finger.link = link;
    finger.tip = tip;
  }
  return hand;
}

/// A gripper of a thumb, which closes towards smaller angles, and a finger of two joints whose
/// outer one follows the inner one at half its angle.
inline Description two_finger_hand() {
  Description hand;
  hand.name = "gripper";
  hand.joints = {{"thumb", {-1.2, 0.1}}, {"inner", {0, 1.5}}, {"outer", {0.1, 0.85}}};
  const Eigen::Isometry3d out(Eigen::Translation3d(0.05, 0, 0));
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  hand.links = {{.name = "palm"},
                {.name = "thumb", .parent = 0, .T_parent_link = out, .axis = y, .joint = 0},
                {.name = "inner", .parent = 0, .axis = y, .joint = 1},
                {.name = "outer", .parent = 2, .T_parent_link = out, .axis = y, .joint = 2}};
  hand.palm = 0;
  hand.actuators.resize(2);
  hand.actuators[0] = {.name = "close_thumb",
                       .joints = {{.joint = 0, .gear = 2, .share = 0.5, .offset = 0}},
                       .coupling = {},
                       .finger = 0,
                       .stiffness = 2,
                       .command = {-2.4, 0.2},
                       .max_torque = 3,
                       .closing = -0.5,
                       .lever = 0.06,
                       .bend = {-1, 0}};
  hand.actuators[1] = {
      .name = "close_finger",
      .joints = {{.joint = 1}, {.joint = 2, .gear = 0, .share = 0.5, .offset = 0.1}},
      .coupling = {},
      .finger = 1,
      .stiffness = 2,
      .command = {0, 1.5},
      .max_torque = 3,
      .closing = 1,
      .lever = 0.1,
      .bend = {0, 1}};
  const TipCapsule tip{{0.01, 0, 0}, {0.03, 0, 0}, 0.008};
  hand.fingers = {{"thumb", 1, tip}, {"finger", 3, tip}};
  return hand;
}

}  // namespace palpate::hand
