// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/release/withdraw_phase.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/estimation/mean_load.hpp"
#include "palpate/skills/stop_conditions.hpp"

namespace palpate::skills {
namespace {

constexpr int kWithdrawals = 3;
constexpr double kWider = 0.25;      // rad by which the fingers open further
constexpr std::size_t kWidened = 2;  // actuators of a finger, from the palm on, that open wider
constexpr double kWidenSeconds = 0.5;
constexpr double kWithdrawnSeconds = 0.5;  // s of standing still, before the load is measured

hand::ActuatorVector wider(const Executor& robot) {
  hand::ActuatorVector posture = robot.command().positions;
  for (int finger = 0; finger < robot.model().finger_count(); ++finger) {
    auto closing = hand::closing_actuators(robot.model(), finger);
    if (closing.size() > kWidened) closing.resize(kWidened);
    for (const int i : closing) {
      const auto& actuator = robot.actuators()[static_cast<std::size_t>(i)];
      const double back = actuator.closing > 0 ? -kWider : kWider;
      posture[i] = std::clamp(posture[i] + back, actuator.command.low, actuator.command.high);
    }
  }
  return posture;
}

}  // namespace

PhaseEnd WithdrawPhase::run(Executor& robot, PickState&) {
  const hand::MountPosition low = robot.command().mount;
  hand::MountPosition high = low;
  high.xyz.z() += options_.distance;
  int attempt = 0;
  bool caught = true;
  for (; caught && attempt < kWithdrawals; ++attempt) {
    if (attempt > 0) {
      robot.move_mount(low, options_.speed);
      robot.move_fingers(wider(robot), kWidenSeconds);
    }
    const auto pulled = lasting_load(robot, Eigen::Vector3d::UnitZ(), options_.caught);
    caught = robot.move_mount(high, options_.speed, pulled) == MotionEnd::stopped;
  }
  hand::MountPosition far = robot.command().mount;
  far.xyz.z() = std::max(far.xyz.z(), options_.height);
  robot.move_mount(far, options_.far_speed);
  robot.wait(kWithdrawnSeconds);
  robot.add_event(event_);
  const double load = estimation::mean_load(robot.log());
  if (load > options_.empty * weight_) {
    return {false, fmt::format("{:.2f} N still hang in the hand", load)};
  }
  return {true, attempt > 1 ? fmt::format("free after {} tries", attempt) : "free"};
}

}  // namespace palpate::skills
