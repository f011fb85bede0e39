// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/cloud_registration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/geometry/cloud/kd_tree.hpp"
#include "palpate/geometry/cloud/normals.hpp"
#include "registration/clock.hpp"
#include "registration/cloud_instances.hpp"
#include "registration/cloud_matching.hpp"
#include "registration/cloud_refinement.hpp"
#include "registration/cloud_scale.hpp"
#include "registration/final_solve.hpp"
#include "registration/neighbour_rounds.hpp"
#include "registration/surface_motions.hpp"

namespace palpate::registration {
namespace {

using geometry::PointCloud;
using geometry::PointView;

constexpr int kFeatureNeighbours = 100;

/// Squared distance of a cloud's points from their mean, on average.
double squared_size(const PointCloud& cloud) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : cloud.points) mean += p / static_cast<double>(cloud.size());
  double sum = 0;
  for (const auto& p : cloud.points) sum += (p - mean).squaredNorm();
  return sum / static_cast<double>(cloud.size());
}

/// A scene of things that lie far from one another turns freely about a line through them, as far
/// as its size goes; that says nothing of a source that is one of them.
bool is_scene(const PointCloud& from, const PointCloud& to) {
  constexpr double kTimes = 3;
  return squared_size(to) > kTimes * kTimes * squared_size(from);
}

/// @return whether either cloud can be slid along itself, which no pose can show
bool is_degenerate(const PointCloud& from, const PointCloud& to, const AllowedTurns& turns,
                   int threads, RegistrationResult& result) {
  std::vector<FreeMotion> motions[2];
  parallel_for(is_scene(from, to) ? 1 : 2, threads, [&](std::size_t k) {
    motions[k] = free_surface_motions(k == 0 ? from : to, turns);
  });
  result.free_motions = std::move(motions[motions[1].empty() ? 0 : 1]);
  result.rank = 6 - static_cast<int>(result.free_motions.size());
  return !result.free_motions.empty();
}

/// Mean distance of a cloud's points to the nearest that is no copy of theirs. Copies, exact or
/// nearly, show where the 2k-th neighbour is far beyond the k-th.
/// @param least  to the nearest of all
double spacing_of_copies(const geometry::KdTree& tree, double least) {
  constexpr std::size_t kLooked = 64;
  constexpr int kMaxCopies = 128;
  constexpr double kJump = 100;
  const std::size_t step = std::max<std::size_t>(1, tree.points().size() / kLooked);
  const int most = std::min(kMaxCopies, static_cast<int>(tree.points().size()) - 1);
  std::vector<double> sums(static_cast<std::size_t>(most) + 1, 0);  // of distances to the k-th
  double looked = 0;
  for (std::size_t i = 0; i < tree.points().size(); i += step, ++looked) {
    const auto near = tree.nearest(tree.points()[i], most + 1);
    for (std::size_t k = 1; k < sums.size(); ++k) sums[k] += std::sqrt(near[k].squared_distance);
  }
  for (std::size_t k = 1; 2 * k < sums.size(); k *= 2) {
    if (sums[2 * k] > kJump * sums[k]) least = sums[2 * k] / looked;
  }
  return least;
}

/// Mean distance of the points that a cell leaves to their neighbours, of some of them; 0 for fewer
/// than three.
double spacing(const PointCloud& cloud, double cell) {
  constexpr std::size_t kLooked = 400;
  const PointCloud sampled = cell > 0 ? geometry::voxel_sampled(cloud, cell) : cloud;
  if (sampled.size() < 3) return 0;
  const geometry::KdTree tree(sampled.points);
  const std::size_t step = cell > 0 ? std::max<std::size_t>(1, sampled.size() / kLooked) : 1;
  double sum = 0, looked = 0;
  for (std::size_t i = 0; i < sampled.size(); i += step, ++looked) {
    sum += std::sqrt(tree.nearest(sampled.points[i], 2)[1].squared_distance);
  }
  return cell > 0 ? sum / looked : spacing_of_copies(tree, sum / looked);
}

double noise_bound_of(const CloudOptions& options, double voxel) {
  return options.noise_bound.value_or(1.5 * voxel);
}

void check_options(const CloudOptions& options) {
  if (options.noise_bound &&
      (!(*options.noise_bound > 0) || !std::isfinite(*options.noise_bound))) {
    throw BadInput(fmt::format("noise bound {} m is not positive", *options.noise_bound));
  }
  if (const double voxel = options.features.voxel; !(voxel >= 0) || !std::isfinite(voxel)) {
    throw BadInput(fmt::format("voxel {} m is not >= 0 and finite", voxel));
  }
  const auto& registration = options.registration;
  check(registration);
  if (registration.estimate_scale && (registration.instances > 1 || registration.initial)) {
    throw BadInput("of clouds, an unknown scale excludes instances and an initial pose");
  }
  if (options.features.refinements == 0 && (registration.estimate_scale || registration.initial)) {
    throw BadInput("an initial pose or an unknown scale of clouds needs refinements, which are 0");
  }
}

void check_described(const FeatureCloud& described) {
  geometry::check_cloud(described.cloud);
  const auto points = described.cloud.size();
  const auto columns = static_cast<std::size_t>(described.features.cols());
  if (columns != points || described.cloud.normals.size() != points) {
    throw BadInput(fmt::format("{} features and {} normals for {} points", columns,
                               described.cloud.normals.size(), points));
  }
}

/// What no pose can exceed among the matches of features, beside what the answer has.
void bound_matches(const CloudOptions& options, CloudRegistration& registration) {
  RegistrationOptions search = feature_search(options, registration);
  search.robust_bound = options.registration.robust_bound;
  registration.feature_inliers = registration.result.inliers.size();
  bound_robustly(registration.correspondences, search, registration.result);
}

/// All steps for prepared clouds.
CloudRegistration register_prepared(const PreparedCloud& from, const PreparedCloud& to,
                                    double voxel, const CloudOptions& options) {
  CloudRegistration registration;
  registration.voxel = voxel;
  registration.noise_bound = noise_bound_of(options, voxel);
  registration.result.false_alarms = 1;
  if (std::min({from.described.cloud.size(), to.described.cloud.size(), from.dense.size(),
                to.dense.size()}) < 3 ||
      is_degenerate(from.dense, to.dense, options.registration.turns(), options.threads,
                    registration.result)) {
    registration.result.status = RegistrationStatus::kDegenerate;
    return registration;
  }
  Alternatives other;
  if (options.registration.initial) {
    registration.result.T_target_source = options.registration.initial;
  } else {
    const double start = now();
    other = match_prepared(from, to, options, registration);
    registration.feature_seconds = now() - start - registration.result.seconds;
  }
  const bool refines = options.features.refinements > 0;
  std::optional<Eigen::Isometry3d> T_better;
  const bool searched = !options.registration.initial;
  if (refines && searched) T_better = prefer_better_fit(from, to, other, options, registration);
  if (searched) bound_matches(options, registration);
  if (!refines) return registration;
  if (registration.result.T_target_source) {
    refine_clouds(from.dense, to.dense, options, registration);
  }
  if (other.T_mirrored) {
    refuse_if_mirrored(from.dense, to.dense, *other.T_mirrored, T_better, options, registration);
  }
  return registration;
}

}  // namespace

double suggested_voxel(const PointCloud& source, const PointCloud& target, int max_points,
                       int threads) {
  const auto most = static_cast<std::size_t>(std::max(1, max_points));
  double cells[2];
  parallel_for(2, threads,
               [&](std::size_t k) { cells[k] = voxel_cell_for(k == 0 ? source : target, most); });
  const double cell = std::max(cells[0], cells[1]);
  // Where the points are hardly more, or copies, a small cell does: their spacing is the scale.
  parallel_for(2, threads,
               [&](std::size_t k) { cells[k] = spacing(k == 0 ? source : target, cell); });
  return std::max({cell, cells[0], cells[1]});
}

FeatureCloud describe(const PointView& cloud, double voxel, const FeatureOptions& options,
                      int threads) {
  FeatureCloud result;
  result.cloud = geometry::voxel_sampled(cloud, voxel);
  if (result.cloud.size() < 3) return result;
  if (!result.cloud.has_normals()) {
    result.cloud = geometry::with_normals(std::move(result.cloud), options.normal_neighbours,
                                          threads, geometry::CollinearPoints::kDrop);
    result.estimated_normals = true;
    if (result.cloud.size() < 3) return result;
  }
  result.features = geometry::fpfh(result.cloud, options.feature_radius_voxels * voxel,
                                   kFeatureNeighbours, threads);
  result.is_fpfh = true;
  return result;
}

CloudRegistration register_described(const FeatureCloud& source, const FeatureCloud& target,
                                     double voxel, const CloudOptions& options) {
  check_options(options);
  if (options.registration.estimate_scale || options.registration.instances > 1) {
    throw BadInput("an unknown scale and instances do not go with features of one's own");
  }
  if (!(voxel > 0) || !std::isfinite(voxel)) {
    throw BadInput(fmt::format("voxel {} m is not positive", voxel));
  }
  for (const FeatureCloud* cloud : {&source, &target}) check_described(*cloud);
  const double start = now();
  CloudRegistration registration =
      register_prepared({source, source.cloud}, {target, target.cloud}, voxel, options);
  registration.result.seconds = now() - start;
  return registration;
}

namespace {

/// One pose at the source's own scale.
CloudRegistration register_once(const PointView& source, const PointView& target,
                                const CloudOptions& options) {
  const double start = now();
  const PointView* clouds[] = {&source, &target};
  PointCloud dense[2];
  parallel_for(2, options.threads, [&](std::size_t k) { dense[k] = thinned(*clouds[k]); });
  const bool given = options.features.voxel > 0;
  const bool initial = options.registration.initial.has_value();  // needs no features
  const double voxel =
      given ? options.features.voxel
            : suggested_voxel(dense[0], dense[1], options.features.max_points, options.threads);
  if (!(voxel > 0)) {
    CloudRegistration none;
    none.result.status = RegistrationStatus::kDegenerate;
    none.result.false_alarms = 1;
    return none;
  }
  FeatureCloud described[2];
  PointCloud with_normals[2] = {dense[0], dense[1]};
  const int threads_each = (options.threads + 1) / 2;
  parallel_for(4, options.threads, [&](std::size_t task) {
    const std::size_t k = task % 2;
    if (task >= 2) {
      add_normals(with_normals[k], options.features, options.threads);
    } else {
      described[k] = initial ? FeatureCloud{dense[k], {}}
                             : describe(given ? *clouds[k] : PointView(dense[k]), voxel,
                                        options.features, threads_each);
    }
  });
  const double described_at = now();
  CloudRegistration registration = register_prepared(
      {described[0], with_normals[0]}, {described[1], with_normals[1]}, voxel, options);
  registration.feature_seconds += described_at - start;
  registration.result.seconds = now() - start;
  return registration;
}

}  // namespace

CloudRegistration register_clouds(const PointView& source, const PointView& target,
                                  const CloudOptions& options) {
  check_options(options);
  for (const auto* cloud : {&source, &target}) geometry::check_cloud(*cloud);
  if (const auto kept = without_far_points(source)) return register_clouds(*kept, target, options);
  if (const auto kept = without_far_points(target)) return register_clouds(source, *kept, options);
  if (options.registration.estimate_scale) return register_scaled_clouds(source, target, options);
  if (options.registration.instances > 1) return register_instances(source, target, options);
  return register_once(source, target, options);
}

}  // namespace palpate::registration
