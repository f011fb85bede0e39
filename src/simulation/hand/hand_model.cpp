// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/hand_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/geometry/query/rounded_hull.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/hand/tip_capsule.hpp"

namespace palpate::simulation {
namespace {

constexpr double kSphereSpacing = 0.024;  // m, between the balls that stand for a link's surface
constexpr double kThinnest = 0.003;       // m, half thickness below which a part is left out
constexpr double kThinnestTip = 0.001;    // m, the same of fingertips
constexpr double kMeshFill = 0.85;
constexpr double kCornerRadius = 0.003;  // m, of the balls in corners
constexpr double kCovered = 0.002;       // m that may stand out of the balls

/// To the corners, the edges' middles and the faces of a cube.
const std::vector<Eigen::Vector3d> kWays = [] {
  std::vector<Eigen::Vector3d> ways;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      for (const double z : {-1.0, 0.0, 1.0}) {
        if (x != 0 || y != 0 || z != 0) ways.emplace_back(x, y, z);
      }
    }
  }
  return ways;
}();

std::string without_prefix(const hand::Description& hand, const std::string& name) {
  return name.starts_with(hand.file.prefix) ? name.substr(hand.file.prefix.size()) : name;
}

std::string name_of(const mjModel& model, mjtObj type, int id) {
  const char* name = mj_id2name(&model, type, id);
  return name ? name : fmt::format("{}_{}", mju_type2Str(type), id);
}

/// One past the hand's last body: bodies come depth first.
int end_of_hand(const mjModel& model, int root) {
  int end = root + 1;
  while (end < model.nbody && model.body_parentid[end] >= root) ++end;
  return end;
}

/// Links that a body is made of: one a joint, and one more where the last does not turn about the
/// body's origin.
int links_of_body(const mjModel& model, int body) {
  const int joints = model.body_jntnum[body];
  if (joints == 0) return 1;
  const int last = model.body_jntadr[body] + joints - 1;
  return joints + (vector3(model.jnt_pos + 3 * last).norm() > 0);
}

const char* joint_type(int type) {
  return type == mjJNT_SLIDE ? "slide" : type == mjJNT_BALL ? "ball joint" : "free joint";
}

/// Adds the links of a body that joints move.
void add_jointed(const mjModel& model, int body, const JointNamer& joint_of, hand::Link link,
                 hand::Description& hand) {
  const std::string body_name = link.name;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // of the link, in the body's frame
  for (int i = 0; i < model.body_jntnum[body]; ++i) {
    const int joint = model.body_jntadr[body] + i;
    const std::string name = name_of(model, mjOBJ_JOINT, joint);
    if (model.jnt_type[joint] != mjJNT_HINGE) {
      throw BadInput(fmt::format("link {} is not joined by hinges: {} is a {}", body_name, name,
                                 joint_type(model.jnt_type[joint])));
    }
    const Eigen::Vector3d anchor = vector3(model.jnt_pos + 3 * joint);
    const NamedJoint named = joint_of(name);
    link.T_parent_link.translate(anchor - origin);
    const Eigen::Vector3d axis = vector3(model.jnt_axis + 3 * joint);
    const double drawn_at = model.qpos0[model.jnt_qposadr[joint]];  // its `ref`
    if (drawn_at != 0) link.T_parent_link.rotate(Eigen::AngleAxisd(-drawn_at, axis));
    link.axis = named.sign * axis;
    link.joint = named.joint;
    origin = anchor;
    const bool last = i + 1 == model.body_jntnum[body] && anchor.isZero();
    link.name = last ? body_name : body_name + "." + name;
    hand.links.push_back(link);
    link = {.name = body_name, .parent = static_cast<int>(hand.links.size()) - 1};
  }
  if (origin.isZero()) return;
  link.T_parent_link.translate(-origin);
  hand.links.push_back(link);
}

/// @param is_moved  whether joints of the file move the body
void add_link(const mjModel& model, int body, bool is_moved, const std::vector<int>& links,
              const JointNamer& joint_of, hand::Description& hand) {
  hand::Link link;
  link.name = without_prefix(hand, name_of(model, mjOBJ_BODY, body));
  link.T_parent_link = pose3(model.body_pos + 3 * body, model.body_quat + 4 * body);
  link.parent = links[static_cast<std::size_t>(model.body_parentid[body])];
  if (is_moved) {
    add_jointed(model, body, joint_of, link, hand);
  } else {
    hand.links.push_back(link);
  }
}

hand::TipCapsule read_tip(const mjModel& model, int geom) {
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

/// @param thinnest  m, the least radius of what is represented
void add_spheres(const mjModel& model, int geom, int link, double thinnest,
                 std::vector<hand::LinkSphere>& spheres) {
  const Eigen::Isometry3d T = pose3(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
  const Eigen::Vector3d center = vector3(model.geom_aabb + 6 * geom);
  const Eigen::Vector3d half = extents(model, geom);
  const double radius = half.minCoeff();
  if (radius < thinnest) return;
  for (double x : offsets(half.x(), radius)) {
    for (double y : offsets(half.y(), radius)) {
      for (double z : offsets(half.z(), radius)) {
        spheres.push_back({link, T * (center + Eigen::Vector3d(x, y, z)), radius});
      }
    }
  }
}

/// The point of a geom's convex hull that is farthest in a direction, both in the body's frame.
Eigen::Vector3d support(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& way) {
  return *std::max_element(points.begin(), points.end(), [&](const auto& one, const auto& other) {
    return one.dot(way) < other.dot(way);
  });
}

/// Whether a point of a link is within kCovered of the balls that stand for it.
bool is_covered(const std::vector<hand::LinkSphere>& spheres, int link, const Eigen::Vector3d& p) {
  return std::ranges::any_of(spheres, [&](const hand::LinkSphere& ball) {
    return ball.link == link && (p - ball.center).norm() < ball.radius + kCovered;
  });
}

/// Small balls that touch the hull of a box or mesh from inside where it reaches farthest, in 26
/// directions: what the larger ones leave out.
void add_corners(const mjModel& model, int geom, int link, std::vector<hand::LinkSphere>& spheres) {
  const int type = model.geom_type[geom];
  if (type != mjGEOM_BOX && type != mjGEOM_MESH) return;
  const std::vector<Eigen::Vector3d> points = geom_points(model, geom);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& p : points) middle += p / static_cast<double>(points.size());
  for (const Eigen::Vector3d& way : kWays) {
    const Eigen::Vector3d p = support(points, way);
    const double depth = (p - middle).norm();
    if (depth < kCornerRadius || is_covered(spheres, link, p)) continue;
    spheres.push_back({link, p - kCornerRadius / depth * (p - middle), kCornerRadius});
  }
}

/// Balls within a fingertip's hull: along its middle as large as they can be, and in its corners.
void add_hull(const hand::Finger& finger, std::vector<hand::LinkSphere>& spheres) {
  constexpr int kAlong = 5;
  const geometry::RoundedHull hull(finger.hull->core, finger.hull->radius);
  for (int i = 0; i < kAlong; ++i) {
    const double share = static_cast<double>(i) / (kAlong - 1);
    const Eigen::Vector3d p = finger.tip.a + share * (finger.tip.b - finger.tip.a);
    const double room = hull.radius() - hull.above_facets(p);
    if (room > hull.radius()) spheres.push_back({finger.link, p, room});
  }
  for (const Eigen::Vector3d& way : kWays) {
    const Eigen::Vector3d p = support(finger.hull->core, way);
    if (is_covered(spheres, finger.link, p + hull.radius() * way.normalized())) continue;
    spheres.push_back({finger.link, p, hull.radius()});
  }
}

}  // namespace

std::vector<int> links_of_bodies(const mjModel& model, int root, RootJoints root_joints) {
  std::vector<int> links(static_cast<std::size_t>(model.nbody), -1);
  int next = 0;
  for (int body = root; body < end_of_hand(model, root); ++body) {
    const bool is_fixed = body == root && root_joints == RootJoints::left_out;
    next += is_fixed ? 1 : links_of_body(model, body);
    links[static_cast<std::size_t>(body)] = next - 1;
  }
  return links;
}

void read_links(const mjModel& model, int root, const std::string& palm, const JointNamer& joint_of,
                const std::vector<int>& tips, hand::Description& hand, RootJoints root_joints) {
  const std::vector<int> links = links_of_bodies(model, root, root_joints);
  const int end = end_of_hand(model, root);
  hand.links.clear();
  hand.spheres.clear();
  for (int body = root; body < end; ++body) {
    const bool is_fixed = body == root && root_joints == RootJoints::left_out;
    const bool is_moved = !is_fixed && model.body_jntnum[body] > 0;
    add_link(model, body, is_moved, links, joint_of, hand);
  }
  hand.palm = links[static_cast<std::size_t>(find_id(model, mjOBJ_BODY, palm))];
  for (std::size_t i = 0; i < tips.size(); ++i) {
    hand.fingers[i].link = links[static_cast<std::size_t>(model.geom_bodyid[tips[i]])];
    if (!hand.fingers[i].hull) hand.fingers[i].tip = read_tip(model, tips[i]);
  }
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    if (body < root || body >= end) continue;
    if (model.geom_contype[geom] == 0 && model.geom_conaffinity[geom] == 0) continue;
    const int link = links[static_cast<std::size_t>(body)];
    const auto tip = std::ranges::find(tips, geom);
    if (tip != tips.end() && hand.fingers[static_cast<std::size_t>(tip - tips.begin())].hull) {
      add_hull(hand.fingers[static_cast<std::size_t>(tip - tips.begin())], hand.spheres);
      continue;
    }
    add_spheres(model, geom, link, tip == tips.end() ? kThinnest : kThinnestTip, hand.spheres);
    if (!hand.file.own_servos || link == 0) add_corners(model, geom, link, hand.spheres);
  }
}

void read_drives(const mjModel& model, hand::Description& hand) {
  for (hand::Actuator& actuator : hand.actuators) {
    const int id = find_id(model, mjOBJ_ACTUATOR, file_actuator(hand, actuator.name));
    const mjtNum* const range = model.actuator_ctrlrange + 2 * id;
    actuator.stiffness = model.actuator_gainprm[mjNGAIN * id];
    actuator.command = {range[0], range[1]};
    actuator.max_torque = model.actuator_forcerange[2 * id + 1];
  }
}

}  // namespace palpate::simulation
