// SPDX-License-Identifier: Apache-2.0
#include "skills/motion/take_posture.hpp"

#include "palpate/hand/self_clearance.hpp"

namespace palpate::skills {
namespace {

constexpr int kLooks = 5;  // on the way

bool way_is_clear(const hand::Description& hand, const hand::ActuatorVector& from,
                  const hand::ActuatorVector& to) {
  const auto at = [&](const hand::ActuatorVector& positions) {
    return hand::joints_in_free_flexion(hand, positions);
  };
  const hand::SelfClearance clearance(hand, at(hand.postures.stretched));
  for (int i = 1; i < kLooks; ++i) {
    const double share = static_cast<double>(i) / kLooks;
    if (!clearance.is_clear(at(from + share * (to - from)))) return false;
  }
  return true;
}

}  // namespace

bool fingers_meet(const Executor& robot, const hand::ActuatorVector& posture) {
  return !way_is_clear(robot.model(), robot.command().positions, posture);
}

void take_posture(Executor& robot, const hand::ActuatorVector& posture, double seconds) {
  if (fingers_meet(robot, posture)) {
    robot.move_fingers(robot.model().postures.stretched, seconds);
  }
  robot.move_fingers(posture, seconds);
}

}  // namespace palpate::skills
