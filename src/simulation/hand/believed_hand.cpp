// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/believed_hand.hpp"

#include <string>

#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {

void place_links(const hand::HandModel& believed, mjModel& model) {
  for (const hand::Link& link : believed.links) {
    if (link.parent < 0) continue;
    const int body = find_id(model, mjOBJ_BODY, std::string(kRight) + link.name);
    Eigen::Vector3d::Map(model.body_pos + 3 * body) = link.T_parent_link.translation();
  }
}

}  // namespace palpate::simulation
