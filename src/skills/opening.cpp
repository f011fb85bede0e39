// SPDX-License-Identifier: Apache-2.0
#include "skills/opening.hpp"

#include <algorithm>

#include "palpate/hand/tip_forces.hpp"

namespace palpate::skills {
namespace {

constexpr double kUnloadSeconds = 0.3;
constexpr double kOpeningSeconds = 0.6;
constexpr int kSteps = 12;         // after each of which the hand may give way
constexpr double kPushed = 3.0;    // N
constexpr double kYield = 0.005;   // m
constexpr double kUpSpeed = 0.30;  // m/s

bool is_pushed(const Executor& robot) {
  const hand::HandReading& reading = robot.reading();
  double most = -reading.mount_force.z();
  for (int finger = 0; finger < robot.model().finger_count(); ++finger) {
    if (robot.trusted(finger)) most = std::max(most, hand::tip_force(reading, finger));
  }
  return most > kPushed;
}

}  // namespace

hand::ActuatorVector unloaded(const Executor& robot) {
  hand::ActuatorVector posture = robot.command().positions;
  for (Eigen::Index i = 0; i < posture.size(); ++i) {
    const auto& actuator = robot.actuators()[static_cast<std::size_t>(i)];
    if (actuator.finger < 0) continue;
    posture[i] -= robot.reading().torques[i] / actuator.stiffness;
  }
  return posture;
}

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

void open_yielding(Executor& robot, const hand::ActuatorVector& posture, double seconds) {
  const hand::ActuatorVector from = robot.command().positions;
  for (int i = 1; i <= kSteps; ++i) {
    const double share = static_cast<double>(i) / kSteps;
    robot.move_fingers(from + share * (posture - from), seconds / kSteps);
    if (!is_pushed(robot)) continue;
    hand::MountPosition up = robot.command().mount;
    up.xyz.z() += kYield;
    robot.move_mount(up, kUpSpeed);
  }
}

void open_yielding(Executor& robot) {
  robot.move_fingers(unloaded(robot), kUnloadSeconds);
  open_yielding(robot, opened(robot), kOpeningSeconds);
}

}  // namespace palpate::skills
