// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/integral_action.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::simulation {

const hand::ActuatorVector& IntegralAction::update(const hand::ActuatorVector& errors,
                                                   const hand::ActuatorVector& stiffness,
                                                   double dt) {
  if (torques_.size() != errors.size()) torques_.setZero(errors.size());
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    if (std::abs(errors[i]) <= options_.deadband) continue;
    torques_[i] = std::clamp(torques_[i] + stiffness[i] * errors[i] * dt / options_.time,
                             -options_.limit, options_.limit);
  }
  return torques_;
}

}  // namespace palpate::simulation
