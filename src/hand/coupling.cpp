// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/coupling.hpp"

#include <algorithm>

namespace palpate::hand {

CoupledAngles share_in_free_flexion(double j0, const Coupling& coupling) {
  static const double end = shadow_ranges()[static_cast<std::size_t>(joint_index("FFJ2"))].high;
  const double both = std::max(0.0, j0 - coupling.follow_angle);
  const double j2 = std::min(j0 - 0.5 * both, end);
  return {.j1 = j0 - j2, .j2 = j2};
}

double j0_for_middle(double j2, const Coupling& coupling) {
  return j2 + std::max(0.0, j2 - coupling.follow_angle);
}

JointVector joints_in_free_flexion(const ActuatorVector& positions) {
  JointVector joints;
  int joint = 0;
  for (int actuator = 0; actuator < kActuators; ++actuator) {
    if (kActuatorNames[static_cast<std::size_t>(actuator)].back() == '0') {
      const CoupledAngles pair = share_in_free_flexion(positions[actuator]);
      joints[joint++] = pair.j2;
      joints[joint++] = pair.j1;
    } else {
      joints[joint++] = positions[actuator];
    }
  }
  return joints;
}

}  // namespace palpate::hand
