// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/localization/information/next_touch.hpp"

namespace palpate::skills {

/// Expected information about its pose by a way to touch more of the object, and how long it takes.
struct ExpectedGain {
  double information = 0;  ///< lower bound, nats
  double seconds = 1;      ///< of the robot's time
  [[nodiscard]] double rate() const { return information / seconds; }
};

/// How exactly what the fingers will sense is known for a mode: not better than the mode's own
/// pose.
inline localization::NextTouchOptions touches_of_modes() {
  localization::NextTouchOptions options;
  options.point_sigma = 0.004;
  options.normal_sigma = 0.35;
  return options;
}

}  // namespace palpate::skills
