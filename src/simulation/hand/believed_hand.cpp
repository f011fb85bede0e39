// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/believed_hand.hpp"

#include <string>

#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {

void place_links(const hand::Description& believed, mjModel& model) {
  for (const hand::Link& link : believed.links) {
    if (link.parent < 0) continue;
    const int body = mj_name2id(&model, mjOBJ_BODY, file_link(believed, link.name).c_str());
    if (body < 0) continue;  // one of several links that a body is made of
    Eigen::Vector3d::Map(model.body_pos + 3 * body) = link.T_parent_link.translation();
  }
}

}  // namespace palpate::simulation
