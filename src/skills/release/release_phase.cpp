// SPDX-License-Identifier: Apache-2.0
#include "skills/release/release_phase.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/hand/tip_forces.hpp"
#include "skills/last_contacts.hpp"
#include "skills/motion/motion_constants.hpp"
#include "skills/release/opening.hpp"

namespace palpate::skills {
namespace {

constexpr double kLoweringSpeed = 0.10;      // m/s
constexpr double kRisingSpeed = 0.30;        // m/s
constexpr double kTouchdown = 10.0;          // N, from below: what slipped meets the table first
constexpr double kReleaseSeconds = 0.6;      // s
constexpr double kSensedWeight = 0.5;        // N
constexpr double kReleaseRestSeconds = 0.3;  // s
constexpr double kGraspRestSeconds = 0.25;   // s

hand::MountPosition at_height(hand::MountPosition mount, double height) {
  mount.xyz.z() = height;
  return mount;
}

/// The fingers' command with all of them straight.
hand::ActuatorVector straightened(const Executor& robot) {
  const hand::ActuatorVector& straight = robot.model().postures.released;
  hand::ActuatorVector posture = robot.command().positions;
  for (Eigen::Index i = 0; i < posture.size(); ++i) {
    const hand::Actuator& actuator = robot.actuators()[static_cast<std::size_t>(i)];
    if (actuator.finger < 0) continue;
    posture[i] = actuator.closing < 0 ? std::max(posture[i], straight[i])
                                      : std::min(posture[i], straight[i]);
  }
  return posture;
}

bool holds_something(const Executor& robot) {
  return hand::count_contacts(robot.reading()) > 0 ||
         robot.reading().mount_force.z() > kSensedWeight;
}

}  // namespace

PhaseEnd ReleasePhase::run(Executor& robot, PickState& state) {
  state.place = place_of_last_contacts(robot).value_or(state.place);
  const auto closed = robot.log().at(estimation::TouchEvent::closed);
  if (closed && holds_something(robot)) {
    const double height = robot.log().readings[*closed].mount.xyz.z();
    const auto& mount = robot.command().mount;
    const auto touchdown = [](const hand::HandReading& reading) {
      return reading.mount_force.z() < -kTouchdown;
    };
    if (mount.xyz.z() > height)
      robot.move_mount(at_height(mount, height), kLoweringSpeed, touchdown);
  }
  robot.set_grip(std::nullopt);
  open_yielding(robot);
  const hand::MountPosition& mount = robot.command().mount;
  robot.move_mount(at_height(mount, std::max(mount.xyz.z(), kFreeHeight)), kRisingSpeed);
  robot.move_fingers(straightened(robot), kReleaseSeconds);
  robot.add_event(estimation::TouchEvent::released);
  return {true, fmt::format("next try at ({:.0f}, {:.0f}) mm", 1e3 * state.place.x(),
                            1e3 * state.place.y())};
}

PhaseEnd ClearPhase::run(Executor& robot, PickState&) {
  robot.set_grip(std::nullopt);
  hand::MountPosition high = robot.command().mount;
  high.xyz.z() = std::max(high.xyz.z(), kFreeHeight);
  robot.move_mount(high, kRisingSpeed);
  robot.move_fingers(straightened(robot), kReleaseSeconds);
  high.ypr.setZero();
  robot.move_mount(high, kRisingSpeed);
  robot.wait(kReleaseRestSeconds);
  robot.add_event(estimation::TouchEvent::released);
  return {true, "the hand is free"};
}

PhaseEnd OpenPhase::run(Executor& robot, PickState&) {
  robot.wait(kGraspRestSeconds);
  release(robot, options_);
  const int contacts = hand::count_contacts(robot.reading());
  return {contacts == 0, fmt::format("{} contacts left", contacts)};
}

}  // namespace palpate::skills
