// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/tip_capsule.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "palpate/core/error.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/geometry/query/rounded_hull.hpp"

namespace palpate::simulation {
namespace {

constexpr double kMinLength = 1e-4;    // m, of a capsule's axis
constexpr double kMaxLength = 0.025;   // m: only the end of a long link is its tip
constexpr double kMinRadius = 0.003;   // m
constexpr double kEdgeRadius = 0.001;  // m, of a hull's rounded edges
constexpr double kMostOf = 0.75;       // of a tip's length, that its outermost geom makes up
constexpr int kAround = 24;            // points of a round geom's circumference

Eigen::Isometry3d geom_pose(const mjModel& model, int geom) {
  return pose3(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
}

/// How far a geom reaches from a point.
double extent_from(const mjModel& model, int geom, const Eigen::Vector3d& from) {
  double farthest = 0;
  for (const auto& p : geom_points(model, geom)) farthest = std::max(farthest, (p - from).norm());
  return farthest;
}

bool is_capsule(const mjModel& model, int geom) {
  const int type = model.geom_type[geom];
  return type == mjGEOM_CAPSULE || type == mjGEOM_SPHERE;
}

/// The geom of a fingertip that reaches farthest from a point; a capsule or sphere also if another
/// one, as a nail, reaches beyond it by less than its radius.
int outermost_geom(const mjModel& model, int body, const Eigen::Vector3d& from) {
  const auto reach = [&](int geom) {
    const double rounded = is_capsule(model, geom) ? model.geom_size[3 * geom] : 0;
    return extent_from(model, geom, from) + rounded;
  };
  int best = -1;
  for (int i = 0; i < model.body_geomnum[body]; ++i) {
    const int geom = model.body_geomadr[body] + i;
    if (model.geom_contype[geom] == 0 && model.geom_conaffinity[geom] == 0) continue;
    if (best < 0 || reach(geom) > reach(best)) best = geom;
  }
  return best;
}

/// Points of an ellipsoid, or of a cylinder's two ends, in the geom's frame.
std::vector<Eigen::Vector3d> round_points(const mjModel& model, int geom) {
  const bool cylinder = model.geom_type[geom] == mjGEOM_CYLINDER;
  Eigen::Vector3d size = vector3(model.geom_size + 3 * geom);
  if (cylinder) size = {size.x(), size.x(), size.y()};
  if (is_capsule(model, geom)) size = vector3(model.geom_aabb + 6 * geom + 3);
  std::vector<Eigen::Vector3d> points;
  for (int ring = cylinder ? -1 : -kAround / 4; ring <= (cylinder ? 1 : kAround / 4); ++ring) {
    const double height = cylinder ? ring : std::sin(2 * std::numbers::pi * ring / kAround);
    const double width = cylinder ? 1 : std::sqrt(1 - height * height);
    for (int i = 0; i < kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      const Eigen::Vector3d unit(width * std::cos(angle), width * std::sin(angle), height);
      points.emplace_back(size.cwiseProduct(unit));
    }
  }
  return points;
}

/// Points whose convex hull a geom's is, in its body's frame.
std::vector<Eigen::Vector3d> hull_points(const mjModel& model, int geom) {
  const int type = model.geom_type[geom];
  if (type == mjGEOM_BOX || type == mjGEOM_MESH) return geom_points(model, geom);
  std::vector<Eigen::Vector3d> points;
  const Eigen::Isometry3d T = geom_pose(model, geom);
  for (const Eigen::Vector3d& p : round_points(model, geom)) points.emplace_back(T * p);
  return points;
}

/// Points of all that a body collides with.
/// @param of  those of one geom
std::vector<Eigen::Vector3d> solid_points(
    const mjModel& model, int body,
    const std::function<std::vector<Eigen::Vector3d>(const mjModel&, int geom)>& of) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < model.body_geomnum[body]; ++i) {
    const int geom = model.body_geomadr[body] + i;
    if (model.geom_contype[geom] == 0 && model.geom_conaffinity[geom] == 0) continue;
    const auto own = of(model, geom);
    points.insert(points.end(), own.begin(), own.end());
  }
  return points;
}

/// A capsule or sphere of the file, its outer end last.
hand::TipCapsule as_given(const mjModel& model, int geom, const Eigen::Vector3d& from) {
  const bool capsule = model.geom_type[geom] == mjGEOM_CAPSULE;
  const double half = capsule ? model.geom_size[3 * geom + 1] : kMinLength / 2;
  const Eigen::Isometry3d T = geom_pose(model, geom);
  Eigen::Vector3d a = T * Eigen::Vector3d(0, 0, -half), b = T * Eigen::Vector3d(0, 0, half);
  if ((a - from).norm() > (b - from).norm()) std::swap(a, b);
  return {a, b, model.geom_size[3 * geom]};
}

struct Extent {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double half() const { return 0.5 * (high - low); }
  [[nodiscard]] double middle() const { return 0.5 * (high + low); }
};

}  // namespace

std::vector<Eigen::Vector3d> geom_points(const mjModel& model, int geom) {
  const Eigen::Isometry3d T = geom_pose(model, geom);
  std::vector<Eigen::Vector3d> points;
  if (model.geom_type[geom] == mjGEOM_MESH) {
    const int mesh = model.geom_dataid[geom];
    const float* const vertices = model.mesh_vert + 3 * model.mesh_vertadr[mesh];
    for (int i = 0; i < model.mesh_vertnum[mesh]; ++i) {
      points.push_back(T * Eigen::Vector3f(vertices + 3 * i).cast<double>());
    }
    return points;
  }
  const mjtNum* const box = model.geom_aabb + 6 * geom;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d side(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    points.push_back(T * (vector3(box) + side.cwiseProduct(vector3(box + 3))));
  }
  return points;
}

hand::TipCapsule fit_tip(const mjModel& model, int body, const Eigen::Vector3d& p_base) {
  const int geom = outermost_geom(model, body, p_base);
  if (is_capsule(model, geom)) return as_given(model, geom, p_base);
  const auto points = geom_points(model, geom);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  const Eigen::Matrix3d axes = frame_with_z((mean - p_base).normalized());
  std::array<Extent, 3> extents;
  for (const auto& p : points) {
    const Eigen::Vector3d q = axes.transpose() * p;
    for (int i = 0; i < 3; ++i) extents[static_cast<std::size_t>(i)].add(q[i]);
  }
  for (const auto& p : solid_points(model, body, geom_points))
    extents[2].add((axes.transpose() * p).z());
  const double across = 0.5 * (extents[0].half() + extents[1].half());
  const double radius = std::max(kMinRadius, std::min(across, extents[2].half()));
  const double end = extents[2].high - radius;
  const double begin = std::clamp(extents[2].low + radius, end - kMaxLength, end - kMinLength);
  const Eigen::Vector3d side(extents[0].middle(), extents[1].middle(), 0);
  return {axes * (side + begin * Eigen::Vector3d::UnitZ()),
          axes * (side + end * Eigen::Vector3d::UnitZ()), radius};
}

std::optional<hand::TipHull> fit_hull(const mjModel& model, int body, const Eigen::Vector3d& p_base,
                                      const hand::TipCapsule& capsule) {
  const int geom = outermost_geom(model, body, p_base);
  if (is_capsule(model, geom)) return std::nullopt;
  const Eigen::Vector3d inward = (capsule.a - capsule.b).normalized();
  const geometry::HalfSpace end{inward, inward.dot(capsule.a) + capsule.radius};
  auto points = hull_points(model, geom);
  Extent along;
  for (const auto& p : points) along.add(inward.dot(p));
  const double length = (capsule.a - capsule.b).norm() + 2 * capsule.radius;
  if (2 * along.half() < kMostOf * length) points = solid_points(model, body, hull_points);
  const auto hull = geometry::RoundedHull::within(points, kEdgeRadius, end);
  return hand::TipHull{hull.core(), hull.radius()};
}

double reach_beyond(const mjModel& model, int body, const Eigen::Vector3d& p_base,
                    const hand::Finger& finger) {
  const int fitted = outermost_geom(model, body, p_base);
  const auto& [a, b, radius] = finger.tip;
  const Eigen::Vector3d axis = b - a;
  std::optional<geometry::RoundedHull> hull;
  if (finger.hull) hull.emplace(finger.hull->core, finger.hull->radius);
  const auto outside = [&](const Eigen::Vector3d& p, double along) {
    if (hull) return (p - hull->nearest_in_core(p)).norm() - hull->radius();
    return (p - a - std::min(along, 1.0) * axis).norm() - radius;
  };
  double farthest = 0;
  for (int i = 0; i < model.body_geomnum[body]; ++i) {
    const int geom = model.body_geomadr[body] + i;
    if (geom == fitted || (model.geom_contype[geom] == 0 && model.geom_conaffinity[geom] == 0)) {
      continue;
    }
    for (const Eigen::Vector3d& p : hull_points(model, geom)) {
      const double along = (p - a).dot(axis) / axis.squaredNorm();
      if (along < 0) continue;  // behind the part that is the tip
      farthest = std::max(farthest, outside(p, along));
    }
  }
  return farthest;
}

void fit_surface(const mjModel& model, int body, const Eigen::Vector3d& p_base,
                 const std::string& shape, hand::Finger& finger) {
  if (shape != "capsule" && shape != "hull") {
    throw BadInput(fmt::format("tip_shape = '{}' is neither capsule nor hull", shape));
  }
  finger.tip = fit_tip(model, body, p_base);
  if (shape == "hull") finger.hull = fit_hull(model, body, p_base, finger.tip);
}

}  // namespace palpate::simulation
