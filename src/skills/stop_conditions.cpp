// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/stop_conditions.hpp"

namespace palpate::skills {
namespace {

constexpr double kLoadSettles = 0.4;  // s of a motion in which the load is that of setting out
constexpr double kSteadyFor = 0.1;    // s after it over which the load of steady motion is averaged
constexpr int kTicksOfLoad = 3;

constexpr double kImpact = 15;              // N
constexpr double kImpactLoadSettles = 0.1;  // s
constexpr int kTicksOfImpact = 2;

}  // namespace

Executor::StopCondition lasting_load(const Executor& robot, const Eigen::Vector3d& direction,
                                     double load) {
  return [direction, load, start = robot.time(),
          loaded = 0](const hand::HandReading& reading) mutable {
    const bool now =
        reading.time > start + kLoadSettles && direction.dot(reading.mount_force) > load;
    loaded = now ? loaded + 1 : 0;
    return loaded >= kTicksOfLoad;
  };
}

Executor::StopCondition rising_load(const Executor& robot, const Eigen::Vector3d& direction,
                                    double load) {
  return [direction, load, start = robot.time(), steady = 0.0, averaged = 0,
          loaded = 0](const hand::HandReading& reading) mutable {
    const double now = direction.dot(reading.mount_force);
    const double moving = reading.time - start;
    if (moving <= kLoadSettles) return false;
    if (averaged == 0 || moving <= kLoadSettles + kSteadyFor) {
      steady += (now - steady) / ++averaged;
      return false;
    }
    loaded = now - steady > load ? loaded + 1 : 0;
    return loaded >= kTicksOfLoad;
  };
}

Executor::StopCondition impact(const Executor& robot, const Eigen::Vector3d& direction) {
  return [direction, from = robot.time() + kImpactLoadSettles,
          loaded = 0](const hand::HandReading& reading) mutable {
    const bool now = reading.time > from && direction.dot(reading.mount_force) > kImpact;
    loaded = now ? loaded + 1 : 0;
    return loaded >= kTicksOfImpact;
  };
}

Executor::StopCondition load_below(double load, double since) {
  return [load, since, ticks = 0](const hand::HandReading& reading) mutable {
    ticks = reading.time > since && reading.mount_force.z() < load ? ticks + 1 : 0;
    return ticks >= kTicksOfLoad;
  };
}

}  // namespace palpate::skills
