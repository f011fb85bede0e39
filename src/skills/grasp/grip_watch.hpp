// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>

#include "palpate/hand/hand.hpp"
#include "palpate/skills/executor.hpp"

namespace palpate::skills {

/// Notices that fingertips slide off an object that they do not hold: together they press with much
/// less than before. Stiff fingers keep their forces on an object that comes along.
class GripWatch {
 public:
  /// @param robot  which presses as it is to go on pressing
  explicit GripWatch(const Executor& robot);

  /// @return whether the grip is being lost
  bool update(const hand::HandReading& reading);

 private:
  double pressed_;               ///< N, of all fingertips together
  std::deque<double> pressing_;  ///< N, in the last readings
};

}  // namespace palpate::skills
