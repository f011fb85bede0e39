// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/executor.hpp"

namespace palpate::skills {

/// Stop condition: what the base carries has fallen below a load (N) for three ticks in a row, not
/// before a time (s), for setting out takes load off, too.
inline Executor::StopCondition load_below(double load, double since = 0) {
  constexpr int kLoadedTicks = 3;
  return [load, since, ticks = 0](const hand::HandReading& reading) mutable {
    ticks = reading.time > since && reading.base_force.z() < load ? ticks + 1 : 0;
    return ticks >= kLoadedTicks;
  };
}

}  // namespace palpate::skills
