// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/load_hand.hpp"

#include "palpate/core/assets.hpp"

namespace palpate::simulation {

hand::Description load_hand(const std::string& name, double stiffness_scale) {
  (void)name;
  return load_shadow_hand(asset("shadow_hand/right_hand.xml"), stiffness_scale);
}

}  // namespace palpate::simulation
