// SPDX-License-Identifier: Apache-2.0
#include "registration/cloud_instances.hpp"

#include <algorithm>
#include <functional>

#include "palpate/geometry/cloud/kd_tree.hpp"
#include "registration/clock.hpp"
#include "registration/cloud_refinement.hpp"

namespace palpate::registration {
namespace {

using geometry::PointCloud;

/// The target's points, those of poses already found apart from the others.
struct Shared {
  PointCloud left, taken;

  /// Takes what lies within the reach of a placed source.
  /// @return how many points that are
  std::size_t take(const PointCloud& placed, double reach) {
    const geometry::KdTree tree(placed.points);
    std::vector<int> kept;
    const std::size_t before = taken.size();
    for (std::size_t i = 0; i < left.size(); ++i) {
      if (tree.nearest_within(left.points[i], reach).index < 0) {
        kept.push_back(static_cast<int>(i));
      } else {
        taken.points.push_back(left.points[i]);
      }
    }
    left = geometry::subset(left, kept);
    return taken.size() - before;
  }
};

std::size_t count_within(const PointCloud& cloud, const PointCloud& of, double reach) {
  const geometry::KdTree tree(of.points);
  return static_cast<std::size_t>(std::ranges::count_if(
      cloud.points, [&](const auto& p) { return tree.nearest_within(p, reach).index >= 0; }));
}

/// The source's cell, as its copies fill a part of the target only; coarser where the target would
/// keep more points than `max_points` for each of five copies.
double voxel_of_instances(const geometry::PointView& source, const geometry::PointView& target,
                          const CloudOptions& options) {
  constexpr int kMaxCopies = 5;
  const PointCloud from = thinned(source), to = thinned(target);
  const int points = options.features.max_points,
            copies = std::min(kMaxCopies, options.registration.instances);
  return std::max(suggested_voxel(from, from, points, options.threads),
                  suggested_voxel(to, to, copies * points, options.threads));
}

}  // namespace

CloudRegistration register_instances(const geometry::PointView& source,
                                     const geometry::PointView& target,
                                     const CloudOptions& options) {
  const double start = now();
  CloudOptions one = options;
  one.registration.instances = 1;
  if (!(one.features.voxel > 0)) one.features.voxel = voxel_of_instances(source, target, options);
  CloudRegistration registration = register_clouds(source, target, one);
  RegistrationResult& result = registration.result;
  if (!result.T_target_source) return registration;
  one.registration.initial.reset();
  one.registration.robust_bound.max_nodes = 0;
  one.noise_bound = registration.noise_bound;
  const PointCloud all = geometry::copied(source);
  Shared shared{geometry::copied(target), {}};
  shared.take(geometry::transformed(*result.T_target_source, all), registration.noise_bound);
  const int max_tries = 2 * options.registration.instances;
  for (int k = 1, tries = 1; k < options.registration.instances && tries < max_tries; ++tries) {
    const RegistrationResult found = register_clouds(all, shared.left, one).result;
    if (!found.T_target_source) break;
    const PointCloud placed = geometry::transformed(*found.T_target_source, all);
    // Scraps of what is taken, a little off its pose, are no further instance.
    const std::size_t overlapping = count_within(shared.taken, placed, registration.noise_bound);
    if (shared.take(placed, registration.noise_bound) <= overlapping) continue;
    result.instances.push_back(
        {static_cast<int>(found.inliers.size()), *found.T_target_source, found.false_alarms});
    ++k;
  }
  std::ranges::stable_sort(result.instances, std::greater<>(), &RunnerUp::inliers);
  if (!result.instances.empty()) result.runner_up = result.instances.front();
  result.seconds = now() - start;
  return registration;
}

}  // namespace palpate::registration
