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

  /// Pairs every stride-th source point, moved, with its nearest target point, where that is within
  /// the bound and their normals do not part by more than 60 deg, of whichever sign.
  const Correspondences& pair_up(const Eigen::Isometry3d& T, double bound, std::size_t stride) {
    looked_ = (source_.size() + stride - 1) / stride;
    find_nearest(T, bound, stride);
    for (auto* list :
         {&pairs_.source, &pairs_.target, &pairs_.source_normals, &pairs_.target_normals}) {
      list->clear();
    }
    for (std::size_t k = 0; k < looked_; ++k) {
      if (nearest_[k] < 0) continue;
      append_pair(pairs_, source_, k * stride, target_, static_cast<std::size_t>(nearest_[k]));
    }
    return pairs_;
  }

  const Correspondences& pairs() const { return pairs_; }
  PoseEstimate solve() const { return solve_pose(pairs_, {}, primitive_); }

  /// Share of the source's points that have a partner.
  double overlap() const {
    return static_cast<double>(pairs_.size()) / static_cast<double>(looked_);
  }

 private:
  void find_nearest(const Eigen::Isometry3d& T, double bound, std::size_t stride) {
    constexpr double kLeastCosine = 0.5;
    constexpr std::size_t kBlock = 512;
    parallel_for((looked_ + kBlock - 1) / kBlock, threads_, [&](std::size_t block) {
      const std::size_t end = std::min(looked_, (block + 1) * kBlock);
      for (std::size_t k = block * kBlock; k < end; ++k) {
        const std::size_t i = k * stride;
        nearest_[k] = -1;
        const auto found = tree_.nearest_within(T * source_.points[i], bound);
        if (found.index < 0) continue;
        const Eigen::Vector3d& n = target_.normals[static_cast<std::size_t>(found.index)];
        const double cosine = std::abs((T.linear() * source_.normals[i]).dot(n));
        if (cosine > kLeastCosine) nearest_[k] = found.index;
      }
    });
  }

  const PointCloud& source_;
  const PointCloud& target_;
  geometry::KdTree tree_;
  Primitive primitive_;
  int threads_;
  std::vector<int> nearest_;
  std::size_t looked_ = 0;
  Correspondences pairs_;
};

/// @param fine  of 1: what the last bound is held to
bool stays(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, const Eigen::Vector3d& at,
           double bound, double fine) {
  constexpr double kSettledAngle = 1e-5, kSettledShare = 1e-4;  // rad, of the bound
  const Eigen::Isometry3d step = from.inverse() * to;
  return rotation_distance(step.linear(), Eigen::Matrix3d::Identity()) < fine * kSettledAngle &&
         (step * at - at).norm() < fine * kSettledShare * bound;
}

/// The bound narrows; the points are all looked at, and the pose held to the last digit, at the end
/// alone.
struct Stage {
  double narrowing, fine;
  bool all;
};
constexpr Stage kStages[] = {{1, 30, false}, {0.5, 30, false}, {0.25, 1, true}};

std::size_t stride_of(const Stage& stage, std::size_t points) {
  constexpr std::size_t kEnough = 5000;
  return stage.all ? 1 : std::max<std::size_t>(1, points / kEnough);
}

/// Rounds of one stage, to the pose that stays.
/// @param least_share  of the points with a partner
/// @return the last solution, if there was one with pairs enough
std::optional<PoseEstimate> converge(Rounds& rounds, Eigen::Isometry3d T, double bound,
                                     const Stage& stage, std::size_t stride, double least_share,
                                     int most, int& done) {
  constexpr std::size_t kLeastPairs = 6;
  std::optional<PoseEstimate> best;
  while (done < most) {
    const std::size_t pairs = rounds.pair_up(T, bound, stride).size();
    if (pairs < kLeastPairs || rounds.overlap() < least_share) return best;
    PoseEstimate estimate = rounds.solve();
    if (estimate.status == Status::kDegenerate) return best;
    ++done;
    const Eigen::Vector3d at = weighted_means(rounds.pairs(), {}).source;
    const bool settled = stays(T, estimate.T_target_source, at, bound, stage.fine);
    T = estimate.T_target_source;
    best = std::move(estimate);
    if (settled) break;
  }
  return best;
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
  auto free = free_motions_of_overlap(registration.correspondences, best.T_target_source);
  if (!free.empty()) {
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
  const double start = now();
  Rounds rounds(source, target, options.registration.primitive, options.threads);
  bool refined = false;
  Eigen::Isometry3d T = *registration.result.T_target_source;
  double bound = registration.noise_bound, least_share = 0;
  for (const Stage& stage : kStages) {
    const double next_bound = stage.narrowing * registration.noise_bound;
    const auto next = converge(rounds, T, next_bound, stage, stride_of(stage, source.size()),
                               least_share, options.features.refinements, registration.refinements);
    if (!next) break;
    refined = true;
    bound = next_bound;
    T = next->T_target_source;
    if (stage.narrowing == 1) registration.overlap = rounds.overlap();
    // A bound that leaves few of the pairs is below the distance between the points.
    least_share = rounds.overlap() / 2;
  }
  if (!refined) {
    if (options.registration.initial) registration.result.T_target_source.reset();
    return;
  }
  rounds.pair_up(T, bound, 1);
  report(rounds.solve(), rounds, options, registration);
  registration.result.solve_seconds += now() - start;
}

}  // namespace palpate::registration
