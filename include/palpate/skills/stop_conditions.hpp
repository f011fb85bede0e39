// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/executor.hpp"

// What ends a motion of the Executor early: conditions on the load that the mount senses. Each is
// for one motion, which begins when it is made.
namespace palpate::skills {

/// The mount has pushed along `direction` (unit, world) with more than `load` (N) for some ticks in
/// a row. The load of setting out, in the first moments of a motion, does not count.
Executor::StopCondition lasting_load(const Executor& robot, const Eigen::Vector3d& direction,
                                     double load);

/// For some ticks in a row the mount has pushed along `direction` (unit, world) with `load` (N)
/// more than its steady motion takes. That is measured in the motion's first half second, in which
/// nothing stops it.
Executor::StopCondition rising_load(const Executor& robot, const Eigen::Vector3d& direction,
                                    double load);

/// The mount has pushed along `direction` (unit, world) with more than any motion at a guarded
/// move's speed takes: sooner than a small load that rises can be distinguished from the motion's
/// own.
Executor::StopCondition impact(const Executor& robot, const Eigen::Vector3d& direction);

/// What the mount carries has fallen below a load (N) for some ticks in a row, not before a time
/// (s), for setting out takes load off, too.
Executor::StopCondition load_below(double load, double since = 0);

}  // namespace palpate::skills
