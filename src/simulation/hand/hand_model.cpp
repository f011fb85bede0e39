// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/hand_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/simulation/world/world.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

constexpr double kSphereSpacing = 0.024;  // m, between the balls that stand for a link's surface
constexpr double kThinnest = 0.003;       // m, half thickness below which a part is left out
constexpr double kMeshFill = 0.85;

std::string without_prefix(const std::string& name) {
  return name.starts_with(kRight) ? name.substr(kRight.size()) : name;
}

int link_named(const hand::HandModel& hand, const std::string& name) {
  const auto found = std::find_if(hand.links.begin(), hand.links.end(),
                                  [&](const hand::Link& link) { return link.name == name; });
  if (found == hand.links.end()) throw BadInput(fmt::format("the hand has no link {}", name));
  return static_cast<int>(found - hand.links.begin());
}

void read_joint(const mjModel& model, int body, const JointNamer& joint_of, hand::Link& link) {
  const int count = model.body_jntnum[body];
  if (count == 0) return;
  const int joint = model.body_jntadr[body];
  const mjtNum* const anchor = model.jnt_pos + 3 * joint;
  if (count > 1 || model.jnt_type[joint] != mjJNT_HINGE || vector3(anchor).norm() > 0) {
    throw BadInput(fmt::format("link {} is not joined by one hinge at its origin", link.name));
  }
  const NamedJoint named = joint_of(mj_id2name(&model, mjOBJ_JOINT, joint));
  link.axis = named.sign * vector3(model.jnt_axis + 3 * joint);
  link.joint = named.joint;
}

hand::Link read_link(const mjModel& model, int body, int root, const JointNamer& joint_of) {
  hand::Link link;
  link.name = without_prefix(mj_id2name(&model, mjOBJ_BODY, body));
  link.T_parent_link = pose3(model.body_pos + 3 * body, model.body_quat + 4 * body);
  if (body == root) return link;
  link.parent = model.body_parentid[body] - root;
  read_joint(model, body, joint_of, link);
  return link;
}

hand::HandModel::TipCapsule read_tip(const mjModel& model, int geom) {
  const Eigen::Isometry3d T = pose3(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
  const Eigen::Vector3d half = Eigen::Vector3d::UnitZ() * model.geom_size[3 * geom + 1];
  return {T * Eigen::Vector3d(-half), T * half, model.geom_size[3 * geom]};
}

/// Offsets of balls of radius r that fill -half..half along one axis from end to end.
std::vector<double> offsets(double half, double r) {
  const double reach = std::max(0.0, half - r);
  const int count = 1 + static_cast<int>(std::ceil(2 * reach / std::max(kSphereSpacing, r) - 1e-9));
  if (count == 1) return {0.0};
  std::vector<double> result;
  for (int i = 0; i < count; ++i) result.push_back(reach * (2.0 * i / (count - 1) - 1.0));
  return result;
}

/// Half extents of the box in which to lay out balls; those of zero get one ball only.
Eigen::Vector3d extents(const mjModel& model, int geom) {
  const Eigen::Vector3d size = vector3(model.geom_size + 3 * geom);
  switch (model.geom_type[geom]) {
    case mjGEOM_SPHERE:
      return Eigen::Vector3d::Constant(size.x());
    case mjGEOM_CAPSULE:
      return {size.x(), size.x(), size.x() + size.y()};
    case mjGEOM_CYLINDER: {
      // Wide flat ones get one ball in the middle: a grid of them would stick out of the rim.
      const double radius = std::min(size.x(), size.y());
      return {radius, radius, size.y()};
    }
    case mjGEOM_BOX:
      return size;
    default:  // a rounded mesh: balls that fill its whole box would stick out
      return kMeshFill * vector3(model.geom_aabb + 6 * geom + 3);
  }
}

void add_spheres(const mjModel& model, int geom, int root, std::vector<hand::LinkSphere>& spheres) {
  const Eigen::Isometry3d T = pose3(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
  const Eigen::Vector3d center = vector3(model.geom_aabb + 6 * geom);
  const Eigen::Vector3d half = extents(model, geom);
  const double radius = half.minCoeff();
  if (radius < kThinnest) return;
  for (double x : offsets(half.x(), radius)) {
    for (double y : offsets(half.y(), radius)) {
      for (double z : offsets(half.z(), radius)) {
        spheres.push_back(
            {model.geom_bodyid[geom] - root, T * (center + Eigen::Vector3d(x, y, z)), radius});
      }
    }
  }
}

}  // namespace

hand::HandModel read_hand_model(const mjModel& model, int root, const JointNamer& joint_of,
                                const std::array<int, hand::kFingers>& tips) {
  hand::HandModel hand;
  int end = root + 1;  // bodies come depth first, so that a hand's are one after the other
  while (end < model.nbody && model.body_parentid[end] >= root) ++end;
  for (int body = root; body < end; ++body) {
    hand.links.push_back(read_link(model, body, root, joint_of));
  }
  hand.palm = link_named(hand, "palm");
  for (std::size_t i = 0; i < tips.size(); ++i) {
    hand.distal[i] = model.geom_bodyid[tips[i]] - root;
    hand.tips[i] = read_tip(model, tips[i]);
  }
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    if (body < root || body >= end || model.geom_contype[geom] == 0) continue;
    add_spheres(model, geom, root, hand.spheres);
  }
  return hand;
}

hand::HandModel load_shadow_hand(const std::filesystem::path& mjcf) {
  const SpecHandle spec = parse_shadow_hand(mjcf);
  const ModelHandle model = compile(*spec);
  for (std::string_view joint : hand::kJointNames) find_id(*model, mjOBJ_JOINT, mjcf_joint(joint));
  std::array<int, hand::kFingers> tips{};
  for (int finger = 0; finger < hand::kFingers; ++finger) {
    find_id(*model, mjOBJ_BODY, mjcf_distal(finger));
    tips[static_cast<std::size_t>(finger)] = find_id(*model, mjOBJ_GEOM, mjcf_tip(finger));
  }
  constexpr int kForearm = 1;  // the first body after the world
  return read_hand_model(
      *model, kForearm,
      [](const std::string& name) {
        return NamedJoint{hand::joint_index(without_prefix(name)), 1.0};
      },
      tips);
}

}  // namespace palpate::simulation
