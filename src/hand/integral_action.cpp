// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/integral_action.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::hand {

const ActuatorVector& IntegralAction::update(const ActuatorVector& errors,
                                             const ActuatorVector& stiffness, double dt) {
  for (int i = 0; i < kActuators; ++i) {
    if (std::abs(errors[i]) <= options_.deadband) continue;
    torques_[i] = std::clamp(torques_[i] + stiffness[i] * errors[i] * dt / options_.time,
                             -options_.limit, options_.limit);
  }
  return torques_;
}

}  // namespace palpate::hand
