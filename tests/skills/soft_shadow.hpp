// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hand/descriptions.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::skills {

/// The Shadow hand of the model file, with actuators as hand::with_soft_actuators makes them.
inline const hand::Description& soft_shadow() {
  static const auto model =
      hand::with_soft_actuators(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")));
  return model;
}

}  // namespace palpate::skills
