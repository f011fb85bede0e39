// SPDX-License-Identifier: Apache-2.0
#include "geometry/objects/symmetry.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <optional>
#include <utility>

#include "geometry/objects/rotation_group.hpp"
#include "geometry/objects/shape_match.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/geometry/mesh/mass_properties.hpp"

namespace palpate::geometry {
namespace {

using Rotations = std::vector<Eigen::Matrix3d>;

// Rotations closer than this are one: tolerances of 2 mm make a polygon of 12 sides a circle.
constexpr double kSameRotation = 15 * kDegree;

Eigen::Matrix3d about(const Eigen::Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

Eigen::Vector3d across(const Eigen::Vector3d& axis) { return frame_with_z(axis).col(0); }

bool is_axis_of_revolution(const ShapeMatch& match, const Eigen::Vector3d& axis) {
  constexpr int kAngles = 17;  // prime, so that no polygon's symmetries are all of them
  Rotations turns;
  for (int k = 1; k <= kAngles / 2; ++k) turns.push_back(about(axis, 2 * kPi * k / kAngles));
  return match.accept(turns);
}

/// Whether a shape of revolution is the same upside down.
bool flips_over(const ShapeMatch& match, const Eigen::Vector3d& axis) {
  constexpr int kFlips = 5;  // about axes all round
  Rotations flips;
  for (int k = 0; k < kFlips; ++k) {
    flips.push_back(about(about(axis, kPi * k / kFlips) * across(axis), kPi));
  }
  return match.accept(flips);
}

Rotations revolution(const ShapeMatch& match, const Eigen::Vector3d& axis) {
  constexpr int kCount = 180;  // every 2 degrees
  const Eigen::Matrix3d flip = about(across(axis), kPi);
  const bool flips = flips_over(match, axis);
  Rotations group;
  for (int k = 0; k < kCount; ++k) group.push_back(about(axis, 2 * kPi * k / kCount));
  for (int k = 0; flips && k < kCount; ++k) {
    group.push_back(group[static_cast<std::size_t>(k)] * flip);
  }
  group.front().setIdentity();
  return group;
}

Rotations ball() {
  constexpr int kCount = 4000;
  Rotations covering = rotation_grid(kCount);
  covering[nearest_rotation(covering, Eigen::Matrix3d::Identity())] = covering.front();
  covering.front().setIdentity();
  return covering;
}

/// Symmetries about one of the axes, if the shape is one of revolution about it.
std::optional<Rotations> of_revolution(const ShapeMatch& match,
                                       const std::vector<Eigen::Vector3d>& axes) {
  for (const Eigen::Vector3d& axis : axes) {
    if (!is_axis_of_revolution(match, axis)) continue;
    return is_axis_of_revolution(match, across(axis)) ? ball() : revolution(match, axis);
  }
  return std::nullopt;
}

std::vector<Eigen::Vector3d> principal_axes(const TriangleMesh& mesh) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(mass_properties(mesh, 1).inertia);
  const Eigen::Matrix3d& axes = solver.eigenvectors();
  return {axes.col(0), axes.col(1), axes.col(2)};
}

void add_unless_near(Rotations& set, const Eigen::Matrix3d& R, double angle) {
  if (set.empty() || rotation_distance(set[nearest_rotation(set, R)], R) > angle) set.push_back(R);
}

/// Rotations that match best on the coarse field, each the best of its surroundings.
Rotations candidates(const ShapeMatch& match, const std::vector<Eigen::Vector3d>& axes) {
  constexpr int kGrid = 10000;  // about 7 degrees apart
  constexpr std::size_t kKept = 200;
  constexpr double kSurroundings = 10 * kDegree;
  Rotations all = rotation_grid(kGrid);
  for (const Eigen::Vector3d& axis : axes) {
    for (int quarter = 1; quarter < 4; ++quarter) all.push_back(about(axis, quarter * kPi / 2));
  }
  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t i = 0; i < all.size(); ++i) ranked.emplace_back(match.screen(all[i]), i);
  std::ranges::sort(ranked);
  Rotations best;
  for (const auto& [distance, i] : ranked) {
    add_unless_near(best, all[i], kSurroundings);
    if (best.size() == kKept) break;
  }
  return best;
}

/// Rotations within tolerance, no two of them the same, best first.
Rotations accepted(const ShapeMatch& match, const Rotations& candidates) {
  Rotations refined;
  for (const Eigen::Matrix3d& R : candidates) {
    add_unless_near(refined, match.refine_coarsely(R), kSameRotation / 5);
  }
  std::ranges::stable_sort(refined, {}, [&](const auto& R) { return match.screen(R); });
  Rotations accepted = {Eigen::Matrix3d::Identity()};
  for (const Eigen::Matrix3d& R : refined) {
    if (rotation_distance(accepted[nearest_rotation(accepted, R)], R) < kSameRotation) continue;
    const Eigen::Matrix3d exact = match.refine(R);
    if (match.accepts(exact)) add_unless_near(accepted, exact, kSameRotation);
  }
  return accepted;
}

/// Axes about which many of the rotations turn, the most used first.
std::vector<Eigen::Vector3d> shared_axes(const Rotations& rotations) {
  constexpr std::size_t kTried = 3;
  std::vector<std::pair<int, Eigen::Vector3d>> axes;
  for (const Eigen::Matrix3d& R : rotations) {
    const Eigen::Vector3d w = log_so3(R);
    if (w.norm() < kSameRotation) continue;
    const Eigen::Vector3d axis = w.normalized();
    const auto known = std::ranges::find_if(axes, [&](const auto& other) {
      return std::abs(other.second.dot(axis)) > std::cos(kSameRotation / 3);
    });
    if (known == axes.end()) {
      axes.emplace_back(1, axis);
    } else {
      ++known->first;
    }
  }
  std::ranges::stable_sort(axes, [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Eigen::Vector3d> shared;
  for (const auto& [count, axis] : axes) {
    if (shared.size() < kTried) shared.push_back(axis);
  }
  return shared;
}

}  // namespace

std::vector<Eigen::Matrix3d> rotational_symmetries(const TriangleMesh& mesh,
                                                   const Eigen::Vector3d& centroid,
                                                   const SymmetryTolerance& tolerance) {
  if (!(tolerance.mean > 0 && tolerance.quantile_95 > 0 && tolerance.quantile_997 > 0 &&
        tolerance.full_radius > 0)) {
    throw BadInput(fmt::format("symmetry tolerances must be positive, not {}, {}, {} and {} m",
                               tolerance.mean, tolerance.quantile_95, tolerance.quantile_997,
                               tolerance.full_radius));
  }
  const Eigen::Isometry3d T_centroid_mesh(Eigen::Translation3d(-centroid));
  const TriangleMesh centred = transformed(T_centroid_mesh, mesh);
  const ShapeMatch match(centred, tolerance);
  const std::vector<Eigen::Vector3d> axes = principal_axes(centred);
  if (auto group = of_revolution(match, axes)) return *group;
  const Rotations found = accepted(match, candidates(match, axes));
  // Where the principal moments are equal, the axes say nothing: a can as high as it is wide.
  if (auto group = of_revolution(match, shared_axes(found))) return *group;
  return nearest_group(found, kSameRotation);
}

}  // namespace palpate::geometry
