// SPDX-License-Identifier: Apache-2.0
#include "skills/release/opening.hpp"

#include <algorithm>

#include "palpate/hand/tip_forces.hpp"

namespace palpate::skills {
namespace {

constexpr double kUnloadSeconds = 0.3;
constexpr double kOpeningSeconds = 0.6;
constexpr double kOpenedSeconds = 0.25;  // s that the open hand then waits
constexpr int kOpeningSteps = 12;        // after each of which the hand may give way
constexpr double kPushed = 3.0;          // N
constexpr double kYield = 0.005;         // m
constexpr double kYieldSpeed = 0.30;     // m/s

bool is_pushed(const Executor& robot) {
  const hand::HandReading& reading = robot.reading();
  double most = -reading.mount_force.z();
  for (int finger = 0; finger < robot.model().finger_count(); ++finger) {
    if (robot.trust().trusted(finger)) most = std::max(most, hand::tip_force(reading, finger));
  }
  return most > kPushed;
}

/// The posture at which the actuators that press would press no more, rad.
hand::ActuatorVector unloaded(const Executor& robot) {
  hand::ActuatorVector posture = robot.command().positions;
  for (Eigen::Index i = 0; i < posture.size(); ++i) {
    const auto& actuator = robot.actuators()[static_cast<std::size_t>(i)];
    if (actuator.finger < 0) continue;
    posture[i] -= robot.reading().torques[i] / actuator.stiffness;
  }
  return posture;
}

/// The fingers' command with those that close as far open as before a grasp from above, rad.
hand::ActuatorVector opened(const Executor& robot) {
  const hand::ActuatorVector& wide = robot.model().postures.top.open;
  hand::ActuatorVector open = robot.command().positions;
  for (Eigen::Index i = 0; i < open.size(); ++i) {
    const double closing = robot.actuators()[static_cast<std::size_t>(i)].closing;
    if (closing > 0) open[i] = std::min(open[i], wide[i]);
    if (closing < 0) open[i] = std::max(open[i], wide[i]);
  }
  return open;
}

/// Moves all actuators to a posture (rad), and gives way meanwhile.
void move_yielding(Executor& robot, const hand::ActuatorVector& posture, double seconds) {
  const hand::ActuatorVector from = robot.command().positions;
  for (int i = 1; i <= kOpeningSteps; ++i) {
    const double share = static_cast<double>(i) / kOpeningSteps;
    robot.move_fingers(from + share * (posture - from), seconds / kOpeningSteps);
    if (!is_pushed(robot)) continue;
    hand::MountPosition up = robot.command().mount;
    up.xyz.z() += kYield;
    robot.move_mount(up, kYieldSpeed);
  }
}

}  // namespace

void open_yielding(Executor& robot) {
  robot.move_fingers(unloaded(robot), kUnloadSeconds);
  move_yielding(robot, opened(robot), kOpeningSeconds);
}

void release(Executor& robot, const LowerOptions& options) {
  const hand::ActuatorVector& wide = robot.model().postures.top.open;
  robot.add_event(estimation::TouchEvent::placed);
  robot.set_grip(std::nullopt);
  robot.move_fingers(unloaded(robot), options.unload_seconds);
  hand::ActuatorVector open = robot.command().positions;
  for (Eigen::Index i = 0; i < open.size(); ++i) {
    if (robot.actuators()[static_cast<std::size_t>(i)].finger >= 0) open[i] = wide[i];
  }
  move_yielding(robot, open, options.open_seconds);
  robot.wait(kOpenedSeconds);
}

}  // namespace palpate::skills
