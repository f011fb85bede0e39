// SPDX-License-Identifier: Apache-2.0
#include "registration/surface_motions.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "palpate/geometry/cloud/kd_tree.hpp"
#include "palpate/geometry/cloud/normals.hpp"
#include "registration/limited_rotation.hpp"

namespace palpate::registration {
namespace {

constexpr int kNeighbours = 12;        // of a plane fit
constexpr std::size_t kLooked = 1000;  // points of a cloud, roughly

/// Points of a surface, each with two estimates of its normal.
struct NormalPairs {
  std::vector<Eigen::Vector3d> points, first, second;
  double points_a_sample = 1;  // of the surface: neighbours share those that normals are fitted to

  void add(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    points.push_back(p);
    first.push_back(a);
    second.push_back(a.dot(b) < 0 ? Eigen::Vector3d(-b) : b);
  }
};

Vector6d twist_row(const Eigen::Vector3d& arm, const Eigen::Vector3d& normal) {
  Vector6d row;
  row << arm.cross(normal), normal;
  return row;
}

CentredInformation shared_information(const NormalPairs& pairs, const AllowedTurns& turns = {}) {
  CentredInformation result;
  result.weight_sum = static_cast<double>(pairs.points.size());
  for (const auto& p : pairs.points) result.center += p / result.weight_sum;
  for (std::size_t i = 0; i < pairs.points.size(); ++i) {
    const Eigen::Vector3d arm = pairs.points[i] - result.center;
    const Vector6d a = twist_row(arm, pairs.first[i]), b = twist_row(arm, pairs.second[i]);
    result.information.noalias() += 0.5 * (a * b.transpose() + b * a.transpose());
    result.squared_arm += arm.squaredNorm() / result.weight_sum;
  }
  exclude_turns(result, excluded_turns(turns));
  return result;
}

/// Turns in units of the root mean square arm.
Vector6d scale_of(const CentredInformation& about) {
  Vector6d scale = Vector6d::Ones();
  scale.head<3>().setConstant(1 / std::sqrt(std::max(about.squared_arm, 1e-300)));
  return scale;
}

Eigen::SelfAdjointEigenSolver<Matrix6d> eigen_of(const CentredInformation& about) {
  const Vector6d scale = scale_of(about);
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(scale.asDiagonal() * about.information *
                                                 scale.asDiagonal());
}

/// Of the share of the information that a twist about the centre gets if it is free.
double standard_error(const NormalPairs& pairs, const CentredInformation& about,
                      const Vector6d& twist) {
  double squares = 0;
  for (std::size_t i = 0; i < pairs.points.size(); ++i) {
    const Eigen::Vector3d arm = pairs.points[i] - about.center;
    const double product =
        twist_row(arm, pairs.first[i]).dot(twist) * twist_row(arm, pairs.second[i]).dot(twist);
    if (product < 0) squares += product * product;
  }
  const double copies = std::max(1.0, kNeighbours / pairs.points_a_sample);
  return std::sqrt(2 * copies * squares) / about.weight_sum;
}

std::vector<FreeMotion> free_motions_of(const NormalPairs& pairs, const AllowedTurns& turns) {
  // Facets of a mesh and the error of a scan give about this share to motions that slide it.
  constexpr double kSurfaceError = 1e-3;
  constexpr double kDeviations = 4;
  if (pairs.points.empty()) return {};
  const CentredInformation about = shared_information(pairs, turns);
  const Vector6d weakest = scale_of(about).asDiagonal() * eigen_of(about).eigenvectors().col(0);
  return free_motions(about,
                      std::max(kSurfaceError, kDeviations * standard_error(pairs, about, weakest)));
}

/// Of the information, by one estimate of the normals.
double min_share(const geometry::PointCloud& cloud) {
  NormalPairs pairs;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / kLooked);
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    pairs.add(cloud.points[i], cloud.normals[i], cloud.normals[i]);
  }
  const CentredInformation about = shared_information(pairs);
  return eigen_of(about).eigenvalues()[0] / about.weight_sum;
}

/// Looks at some of the points, with a plane fit to each half of all points at each.
NormalPairs normals_of_halves(const geometry::PointCloud& cloud) {
  std::vector<Eigen::Vector3d> halves[2];
  for (std::size_t i = 0; i < cloud.size(); ++i) halves[i % 2].push_back(cloud.points[i]);
  const geometry::KdTree trees[] = {geometry::KdTree(std::move(halves[0])),
                                    geometry::KdTree(std::move(halves[1]))};
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / kLooked);
  NormalPairs pairs;
  pairs.points_a_sample = static_cast<double>(step) / 2;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    const auto a = geometry::plane_normal(trees[0], cloud.points[i], kNeighbours),
               b = geometry::plane_normal(trees[1], cloud.points[i], kNeighbours);
    if (a && b) pairs.add(cloud.points[i], *a, *b);
  }
  return pairs;
}

NormalPairs normals_of_overlap(const Correspondences& pairs, const Eigen::Isometry3d& T) {
  NormalPairs normals;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    normals.add(pairs.target[i], pairs.target_normals[i], T.linear() * pairs.source_normals[i]);
  }
  return normals;
}

}  // namespace

std::vector<FreeMotion> free_surface_motions(const geometry::PointCloud& cloud,
                                             const AllowedTurns& turns) {
  // Noise adds to the shares that one estimate gives: what is large with it needs no second look.
  constexpr double kClear = 0.1;
  if (cloud.has_normals() && min_share(cloud) > kClear) return {};
  return free_motions_of(normals_of_halves(cloud), turns);
}

std::vector<FreeMotion> free_motions_of_overlap(const Correspondences& pairs,
                                                const Eigen::Isometry3d& T_target_source,
                                                const AllowedTurns& turns) {
  return free_motions_of(normals_of_overlap(pairs, T_target_source), turns);
}

std::optional<FreeMotion> weak_rotation(const Correspondences& pairs,
                                        const Eigen::Isometry3d& T_target_source,
                                        const AllowedTurns& turns) {
  constexpr double kWeak = 0.02, kRounding = 1e-9;
  const CentredInformation about =
      shared_information(normals_of_overlap(pairs, T_target_source), turns);
  const double least = eigen_of(about).eigenvalues()[0] / about.weight_sum;
  if (least > kWeak) return std::nullopt;
  const FreeMotion weakest = free_motions(about, least + kRounding).front();
  if (weakest.kind != FreeMotion::Kind::kRotation) return std::nullopt;
  return weakest;
}

}  // namespace palpate::registration
