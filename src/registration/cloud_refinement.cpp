// SPDX-License-Identifier: Apache-2.0
#include "registration/cloud_refinement.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "palpate/core/parallel.hpp"
#include "palpate/geometry/cloud/kd_tree.hpp"
#include "palpate/geometry/cloud/normals.hpp"
#include "registration/clock.hpp"
#include "registration/final_solve.hpp"
#include "registration/surface_motions.hpp"

namespace palpate::registration {
namespace {

using geometry::PointCloud;

/// What a round of nearest neighbours works with; the lists' memory is used again.
class Rounds {
 public:
  Rounds(const PointCloud& source, const PointCloud& target, Primitive primitive, int threads)
      : source_(source),
        target_(target),
        tree_(target.points),
        primitive_(primitive),
        threads_(threads),
        nearest_(source.size()) {}

  /// Pairs every moved source point with its nearest target point, where that is within the bound
  /// and their normals do not part by more than 60 deg, of whichever sign.
  const Correspondences& pair_up(const Eigen::Isometry3d& T, double bound) {
    find_nearest(T, bound);
    for (auto* list :
         {&pairs_.source, &pairs_.target, &pairs_.source_normals, &pairs_.target_normals}) {
      list->clear();
    }
    for (std::size_t i = 0; i < source_.size(); ++i) {
      if (nearest_[i] < 0) continue;
      append_pair(pairs_, source_, i, target_, static_cast<std::size_t>(nearest_[i]));
    }
    return pairs_;
  }

  const Correspondences& pairs() const { return pairs_; }
  PoseEstimate solve() const { return solve_pose(pairs_, {}, primitive_); }

  /// Share of the source's points that have a partner.
  double overlap() const {
    return static_cast<double>(pairs_.size()) / static_cast<double>(source_.size());
  }

 private:
  void find_nearest(const Eigen::Isometry3d& T, double bound) {
    constexpr double kLeastCosine = 0.5;
    constexpr std::size_t kBlock = 1024;
    parallel_for((source_.size() + kBlock - 1) / kBlock, threads_, [&](std::size_t block) {
      const std::size_t end = std::min(source_.size(), (block + 1) * kBlock);
      for (std::size_t i = block * kBlock; i < end; ++i) {
        nearest_[i] = -1;
        const auto found = tree_.nearest_within(T * source_.points[i], bound);
        if (found.index < 0) continue;
        const Eigen::Vector3d& n = target_.normals[static_cast<std::size_t>(found.index)];
        const double cosine = std::abs((T.linear() * source_.normals[i]).dot(n));
        if (cosine > kLeastCosine) nearest_[i] = found.index;
      }
    });
  }

  const PointCloud& source_;
  const PointCloud& target_;
  geometry::KdTree tree_;
  Primitive primitive_;
  int threads_;
  std::vector<int> nearest_;
  Correspondences pairs_;
};

bool stays(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, const Eigen::Vector3d& at,
           double bound) {
  constexpr double kSettledAngle = 1e-5, kSettledShare = 1e-4;  // rad, of the bound
  const Eigen::Isometry3d step = from.inverse() * to;
  return rotation_distance(step.linear(), Eigen::Matrix3d::Identity()) < kSettledAngle &&
         (step * at - at).norm() < kSettledShare * bound;
}

/// Rounds at one bound, to the pose that stays.
/// @return the last solution, if there was one with pairs enough
std::optional<PoseEstimate> converge(Rounds& rounds, Eigen::Isometry3d T, double bound,
                                     std::size_t least_pairs, int most, int& done) {
  std::optional<PoseEstimate> best;
  while (done < most) {
    if (rounds.pair_up(T, bound).size() < least_pairs) return best;
    PoseEstimate estimate = rounds.solve();
    if (estimate.status == Status::kDegenerate) return best;
    ++done;
    const Eigen::Vector3d at = weighted_means(rounds.pairs(), {}).source;
    const bool settled = stays(T, estimate.T_target_source, at, bound);
    T = estimate.T_target_source;
    best = std::move(estimate);
    if (settled) break;
  }
  return best;
}

/// Free motions of the part of the target that the source covers.
std::vector<FreeMotion> free_in_overlap(const Correspondences& pairs) {
  return free_surface_motions({pairs.target, pairs.target_normals});
}

void report(const PoseEstimate& best, const Rounds& rounds, const CloudOptions& options,
            CloudRegistration& registration) {
  RegistrationResult& result = registration.result;
  registration.correspondences = rounds.pairs();
  const std::size_t count = registration.correspondences.size();
  result.weights.assign(count, 1);
  result.inliers.clear();
  for (std::size_t i = 0; i < count; ++i) result.inliers.push_back(static_cast<int>(i));
  PoseEstimate estimate = best;
  if (auto free = free_in_overlap(registration.correspondences); !free.empty()) {
    estimate.status = Status::kDegenerate;
    estimate.rank = 6 - static_cast<int>(free.size());
    estimate.free_motions = std::move(free);
  }
  report_final_solve(estimate, registration.correspondences, options.registration.primitive,
                     result);
  registration.rms_error =
      std::sqrt(best.cost / static_cast<double>(std::max<std::size_t>(1, count)));
}

}  // namespace

void append_pair(Correspondences& pairs, const PointCloud& source, std::size_t i,
                 const PointCloud& target, std::size_t j) {
  pairs.source.push_back(source.points[i]);
  pairs.target.push_back(target.points[j]);
  pairs.source_normals.push_back(source.normals[i]);
  pairs.target_normals.push_back(target.normals[j]);
}

PointCloud detailed(const PointCloud& cloud, const FeatureOptions& options) {
  constexpr std::size_t kMost = 20000;
  const double cell = voxel_cell_for(cloud, kMost);
  PointCloud result = cell > 0 ? geometry::voxel_sampled(cloud, cell) : cloud;
  if (!result.has_normals() && result.size() >= 3) {
    result.normals =
        geometry::plane_normals(geometry::KdTree(result.points), options.normal_neighbours);
  }
  return result;
}

void refine_clouds(const PointCloud& source, const PointCloud& target, const CloudOptions& options,
                   CloudRegistration& registration) {
  constexpr double kNarrowings[] = {1, 0.5, 0.25};
  constexpr std::size_t kLeastPairs = 6;
  const double start = now();
  Rounds rounds(source, target, options.registration.primitive, options.threads);
  std::optional<PoseEstimate> best;
  Eigen::Isometry3d T = *registration.result.T_target_source;
  double bound = registration.noise_bound;
  std::size_t least = kLeastPairs;
  for (const double narrowing : kNarrowings) {
    const auto next = converge(rounds, T, narrowing * registration.noise_bound, least,
                               options.features.refinements, registration.refinements);
    if (!next) break;
    best = next;
    bound = narrowing * registration.noise_bound;
    T = best->T_target_source;
    if (narrowing == 1) registration.overlap = rounds.overlap();
    // A bound that leaves few of the pairs is below the distance between the points.
    least = std::max(kLeastPairs, rounds.pairs().size() / 2);
  }
  if (!best) {
    if (options.registration.initial) registration.result.T_target_source.reset();
    return;
  }
  rounds.pair_up(T, bound);
  report(*best, rounds, options, registration);
  registration.result.solve_seconds += now() - start;
}

}  // namespace palpate::registration
