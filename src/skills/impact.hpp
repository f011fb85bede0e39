// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/executor.hpp"

namespace palpate::skills {

/// Stop condition: the base has pushed along a direction (unit, world) with more than any motion at
/// a guarded move's speed takes: sooner than a small load that rises can be distinguished from the
/// motion's own.
inline Executor::StopCondition impact(const Executor& robot, const Eigen::Vector3d& direction) {
  constexpr double kImpact = 15;         // N
  constexpr double kSettledAfter = 0.1;  // s of a motion in which the load is that of setting out
  return [direction, from = robot.time() + kSettledAfter,
          loaded = 0](const hand::HandReading& reading) mutable {
    const bool now = reading.time > from && direction.dot(reading.base_force) > kImpact;
    loaded = now ? loaded + 1 : 0;
    return loaded >= 2;
  };
}

}  // namespace palpate::skills
