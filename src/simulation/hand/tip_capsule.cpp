// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/tip_capsule.hpp"

#include <algorithm>

#include "palpate/core/se3.hpp"

namespace palpate::simulation {
namespace {

constexpr double kMinLength = 1e-4;   // m, of a capsule's axis
constexpr double kMaxLength = 0.025;  // m: only the end of a long link is its tip
constexpr double kMinRadius = 0.003;  // m

Eigen::Isometry3d geom_pose(const mjModel& model, int geom) {
  return pose3(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
}

/// How far a geom reaches from a point.
double extent_from(const mjModel& model, int geom, const Eigen::Vector3d& from) {
  double farthest = 0;
  for (const auto& p : geom_points(model, geom)) farthest = std::max(farthest, (p - from).norm());
  return farthest;
}

int outermost_geom(const mjModel& model, int body, const Eigen::Vector3d& from) {
  int best = -1;
  for (int i = 0; i < model.body_geomnum[body]; ++i) {
    const int geom = model.body_geomadr[body] + i;
    if (model.geom_contype[geom] == 0 && model.geom_conaffinity[geom] == 0) continue;
    if (best < 0 || extent_from(model, geom, from) > extent_from(model, best, from)) best = geom;
  }
  return best;
}

/// Points of all that a body collides with.
std::vector<Eigen::Vector3d> solid_points(const mjModel& model, int body) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < model.body_geomnum[body]; ++i) {
    const int geom = model.body_geomadr[body] + i;
    if (model.geom_contype[geom] == 0 && model.geom_conaffinity[geom] == 0) continue;
    const auto own = geom_points(model, geom);
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
  const int type = model.geom_type[geom];
  if (type == mjGEOM_CAPSULE || type == mjGEOM_SPHERE) return as_given(model, geom, p_base);
  const auto points = geom_points(model, geom);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  const Eigen::Matrix3d axes = frame_with_z((mean - p_base).normalized());
  std::array<Extent, 3> extents;
  for (const auto& p : points) {
    const Eigen::Vector3d q = axes.transpose() * p;
    for (int i = 0; i < 3; ++i) extents[static_cast<std::size_t>(i)].add(q[i]);
  }
  for (const auto& p : solid_points(model, body)) extents[2].add((axes.transpose() * p).z());
  const double across = 0.5 * (extents[0].half() + extents[1].half());
  const double radius = std::max(kMinRadius, std::min(across, extents[2].half()));
  const double end = extents[2].high - radius;
  const double begin = std::clamp(extents[2].low + radius, end - kMaxLength, end - kMinLength);
  const Eigen::Vector3d side(extents[0].middle(), extents[1].middle(), 0);
  return {axes * (side + begin * Eigen::Vector3d::UnitZ()),
          axes * (side + end * Eigen::Vector3d::UnitZ()), radius};
}

}  // namespace palpate::simulation
