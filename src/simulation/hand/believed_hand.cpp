// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/believed_hand.hpp"

#include <fmt/format.h>

#include <array>
#include <string>

#include "palpate/core/error.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {

namespace {

constexpr std::array<int, 6> kMountAxes = {0, 1, 2, 2, 1, 0};  // of x y z, yaw pitch roll

/// Moves the first link on the mount whose joints carry it: they stay where they are in the world.
void carry_first_link(const hand::Description& believed, mjModel& model) {
  const hand::Link& root = believed.links.front();
  const int body = mj_name2id(&model, mjOBJ_BODY, file_link(believed, root.name).c_str());
  if (body < 0) throw BadInput(fmt::format("the hand's model has no link '{}'", root.name));
  if (model.body_jntnum[body] != static_cast<int>(kMountAxes.size())) return;  // it stands fast
  const Eigen::Isometry3d T_root_mount = root.T_parent_link.inverse();
  write_pose(root.T_parent_link, model.body_pos + 3 * body, model.body_quat + 4 * body);
  for (std::size_t i = 0; i < kMountAxes.size(); ++i) {
    const int joint = model.body_jntadr[body] + static_cast<int>(i);
    Eigen::Vector3d::Map(model.jnt_axis + 3 * joint) = T_root_mount.linear().col(kMountAxes[i]);
    Eigen::Vector3d::Map(model.jnt_pos + 3 * joint) = T_root_mount.translation();
  }
}

}  // namespace

void place_links(const hand::Description& believed, mjModel& model) {
  Eigen::Isometry3d T_parent_body = Eigen::Isometry3d::Identity();
  carry_first_link(believed, model);
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
