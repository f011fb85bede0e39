// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/load_sensor.hpp"

#include <algorithm>
#include <limits>
#include <span>

#include "palpate/skills/executor.hpp"

namespace palpate::skills {
namespace {

constexpr int kSteadyReadings = 10, kSteadyWindows = 10;  // that are averaged; at most
constexpr double kSteadyLoad = 0.15;                      // N between two windows
constexpr double kMaxDrift = 3;  // N that a sensor's error may have changed by; more is a load

struct SteadyLoad {
  Eigen::Vector3d load;  ///< N
  MotionEnd end;         ///< of the last wait
};

SteadyLoad wait_for_steady_load(Executor& robot) {
  Eigen::Vector3d before = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  MotionEnd end = MotionEnd::reached;
  for (int i = 0; i < kSteadyWindows; ++i) {
    end = robot.wait(kSteadyReadings * hand::kTick);
    Eigen::Vector3d now = Eigen::Vector3d::Zero();
    const auto& readings = robot.log().readings;
    const auto count = std::min<std::size_t>(kSteadyReadings, readings.size());
    for (const auto& reading : std::span(readings).last(count)) {
      now += reading.mount_force / static_cast<double>(count);
    }
    const bool steady = (now - before).norm() < kSteadyLoad;
    before = now;
    if (steady) break;
  }
  return {before, end};
}

}  // namespace

void LoadSensor::correct(hand::HandReading& reading) {
  sensed_ = reading.mount_force;
  reading.mount_force -= reading.mount.pose().linear() * error_.bias;
  reading.mount_force.z() -= error_.weight;
}

Eigen::Vector3d steady_load(Executor& robot) { return wait_for_steady_load(robot).load; }

void tare(Executor& robot) {
  const auto [load, end] = wait_for_steady_load(robot);
  if (end == MotionEnd::timed_out || load.norm() > kMaxDrift) return;
  LoadError error = robot.load_sensor().error();
  error.bias += robot.reading().mount.pose().linear().transpose() * load;
  robot.load_sensor().set_error(error);
}

}  // namespace palpate::skills
