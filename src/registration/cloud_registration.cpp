// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/cloud_registration.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/geometry/cloud/kd_tree.hpp"
#include "palpate/geometry/cloud/normals.hpp"
#include "registration/clock.hpp"
#include "registration/fill_in.hpp"

namespace palpate::registration {
namespace {

using geometry::PointCloud;

void append_pair(Correspondences& pairs, const PointCloud& source, std::size_t i,
                 const PointCloud& target, std::size_t j) {
  pairs.source.push_back(source.points[i]);
  pairs.target.push_back(target.points[j]);
  pairs.source_normals.push_back(source.normals[i]);
  pairs.target_normals.push_back(target.normals[j]);
}

Correspondences matched(const FeatureCloud& source, const FeatureCloud& target) {
  Correspondences pairs;
  for (const auto& match : geometry::mutual_matches(source.features, target.features)) {
    append_pair(pairs, source.cloud, static_cast<std::size_t>(match.source), target.cloud,
                static_cast<std::size_t>(match.target));
  }
  return pairs;
}

/// Every moved source point with its nearest target point, where that is within the bound and their
/// normals do not part by more than 60 deg, of whichever sign.
Correspondences nearest_pairs(const PointCloud& source, const PointCloud& target,
                              const geometry::KdTree& tree, const Eigen::Isometry3d& T,
                              double bound) {
  constexpr double kLeastCosine = 0.5;
  Correspondences pairs;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const auto found = tree.nearest(T * source.points[i], 1).front();
    const auto j = static_cast<std::size_t>(found.index);
    const double cosine = std::abs((T.linear() * source.normals[i]).dot(target.normals[j]));
    if (found.squared_distance < bound * bound && cosine > kLeastCosine) {
      append_pair(pairs, source, i, target, j);
    }
  }
  return pairs;
}

/// Nearest neighbours and pose in turn, until the pose stays; the result then speaks of them.
void refine(const PointCloud& source, const PointCloud& target, const CloudOptions& options,
            CloudRegistration& registration) {
  constexpr double kSettledAngle = 1e-5, kSettledShare = 1e-4;  // rad, of the bound
  RegistrationResult& result = registration.result;
  const geometry::KdTree tree(target.points);
  const double bound = registration.noise_bound, start = now();
  PoseEstimate best;
  Eigen::Isometry3d T = *result.T_target_source;
  while (registration.refinements < options.features.refinements) {
    Correspondences pairs = nearest_pairs(source, target, tree, T, bound);
    if (pairs.size() < 6) break;
    PoseEstimate estimate = solve_pose(pairs, {}, options.registration.primitive);
    if (estimate.status == Status::kDegenerate) break;
    ++registration.refinements;
    registration.correspondences = std::move(pairs);
    best = std::move(estimate);
    const Eigen::Isometry3d step = T.inverse() * best.T_target_source;
    T = best.T_target_source;
    const double turn = rotation_distance(step.linear(), Eigen::Matrix3d::Identity());
    const Eigen::Vector3d at = weighted_means(registration.correspondences, {}).source;
    if (turn < kSettledAngle && (step * at - at).norm() < kSettledShare * bound) break;
  }
  if (registration.refinements == 0) return;
  const std::size_t count = registration.correspondences.size();
  fill_in(best, registration.correspondences, result);
  result.weights.assign(count, 1);
  result.inliers.clear();
  for (std::size_t i = 0; i < count; ++i) result.inliers.push_back(static_cast<int>(i));
  result.solve_seconds += now() - start;
}

/// The cloud itself, or so many of its points that nearest neighbours are found soon, with normals.
PointCloud detailed(const PointCloud& cloud, const FeatureOptions& options) {
  constexpr std::size_t kMost = 20000;
  const double cell = voxel_cell_for(cloud, kMost);
  PointCloud result = cell > 0 ? geometry::voxel_sampled(cloud, cell) : cloud;
  if (!result.has_normals()) {
    result = geometry::with_normals(std::move(result), options.normal_neighbours);
  }
  return result;
}

FeatureCloud turned_inside_out(FeatureCloud described, double voxel,
                               const FeatureOptions& options) {
  for (auto& n : described.cloud.normals) n = -n;
  described.features = geometry::fpfh(described.cloud, options.feature_radius_voxels * voxel);
  return described;
}

/// Pose from the matches of features. Estimated normals may all point inward, as those of a part of
/// a surface can. As matches of normals of opposite signs have led to wrong poses with a chance of
/// 5e-9, they are also tried the other way unless the first answer is far clearer: the better
/// stays.
void match_features(FeatureCloud from, const FeatureCloud& to, const CloudOptions& options,
                    CloudRegistration& registration) {
  constexpr double kClear = 1e-30;  // poses that chance may propose
  RegistrationOptions search = options.registration;
  search.noise_bound = registration.noise_bound;
  const int tries = from.estimated_normals || to.estimated_normals ? 2 : 1;
  for (int attempt = 0; attempt < tries; ++attempt) {
    if (attempt > 0) {
      from = turned_inside_out(std::move(from), registration.voxel, options.features);
    }
    Correspondences matches = matched(from, to);
    RegistrationResult found = register_correspondences(matches, search);
    if (attempt == 0 || found.expected_by_chance < registration.result.expected_by_chance) {
      registration.feature_matches = matches.size();
      registration.correspondences = std::move(matches);
      registration.result = std::move(found);
    }
    if (registration.result.expected_by_chance < kClear) break;
  }
}

}  // namespace

double suggested_voxel(const PointCloud& source, const PointCloud& target, int most_points) {
  const auto most = static_cast<std::size_t>(std::max(1, most_points));
  double cell = std::max(voxel_cell_for(source, most), voxel_cell_for(target, most));
  if (cell > 0) return cell;
  // Small clouds stay as they are; their spacing gives the features' scale.
  for (const PointCloud* cloud : {&source, &target}) {
    if (cloud->size() < 3) continue;
    const geometry::KdTree tree(cloud->points);
    double sum = 0;
    for (const auto& p : cloud->points) sum += std::sqrt(tree.nearest(p, 2)[1].squared_distance);
    cell = std::max(cell, sum / static_cast<double>(cloud->size()));
  }
  return cell;
}

FeatureCloud describe(const PointCloud& cloud, double voxel, const FeatureOptions& options) {
  FeatureCloud result;
  result.cloud = geometry::voxel_sampled(cloud, voxel);
  if (result.cloud.size() < 3) return result;
  if (!result.cloud.has_normals()) {
    result.cloud = geometry::with_normals(std::move(result.cloud), options.normal_neighbours);
    result.estimated_normals = true;
  }
  result.features = geometry::fpfh(result.cloud, options.feature_radius_voxels * voxel);
  return result;
}

CloudRegistration register_clouds(const PointCloud& source, const PointCloud& target,
                                  const CloudOptions& options) {
  const double start = now();
  geometry::check_cloud(source);
  geometry::check_cloud(target);
  CloudRegistration registration;
  RegistrationResult& result = registration.result;
  registration.voxel = options.features.voxel > 0
                           ? options.features.voxel
                           : suggested_voxel(source, target, options.features.most_points);
  result.status = Status::kDegenerate;
  if (!(registration.voxel > 0)) return registration;
  const FeatureCloud from = describe(source, registration.voxel, options.features);
  const FeatureCloud to = describe(target, registration.voxel, options.features);
  if (from.cloud.size() < 3 || to.cloud.size() < 3) return registration;

  registration.noise_bound = options.noise_bound.value_or(1.5 * registration.voxel);
  match_features(from, to, options, registration);
  registration.feature_seconds = now() - start - result.seconds;
  if (result.T_target_source) {
    refine(detailed(source, options.features), detailed(target, options.features), options,
           registration);
  }
  result.seconds = now() - start;
  return registration;
}

}  // namespace palpate::registration
