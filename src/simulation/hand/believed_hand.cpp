// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/believed_hand.hpp"

#include <fmt/format.h>

#include <string>

#include "palpate/core/error.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {

void place_links(const hand::Description& believed, mjModel& model) {
  Eigen::Isometry3d T_parent_body = Eigen::Isometry3d::Identity();
  std::string inner;  // BODY.JOINT, the first of several links that a body is made of
  for (const hand::Link& link : believed.links) {
    if (link.parent < 0) continue;
    T_parent_body = T_parent_body * link.T_parent_link;
    const int body = mj_name2id(&model, mjOBJ_BODY, file_link(believed, link.name).c_str());
    if (body < 0) {
      if (inner.empty()) inner = link.name;
      continue;
    }
    if (!inner.empty() && !inner.starts_with(link.name + ".")) break;
    Eigen::Vector3d::Map(model.body_pos + 3 * body) = T_parent_body.translation();
    T_parent_body.setIdentity();
    inner.clear();
  }
  if (!inner.empty()) throw BadInput(fmt::format("the hand's model has no link '{}'", inner));
}

}  // namespace palpate::simulation
