// SPDX-License-Identifier: Apache-2.0
#include "registration/cloud_refinement.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>

#include "palpate/core/statistics.hpp"
#include "palpate/geometry/cloud/kd_tree.hpp"
#include "palpate/geometry/cloud/normals.hpp"
#include "registration/clock.hpp"
#include "registration/cloud_candidates.hpp"
#include "registration/final_solve.hpp"
#include "registration/neighbour_rounds.hpp"
#include "registration/surface_motions.hpp"

namespace palpate::registration {
namespace {

using geometry::PointCloud;

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
constexpr Stage kStages[] = {{1, 50, false}, {0.5, 50, false}, {0.25, 5, true}};

std::size_t stride_of(const Stage& stage, std::size_t points) {
  constexpr std::size_t kEnough = 5000;
  return stage.all ? 1 : std::max<std::size_t>(1, points / kEnough);
}

/// What the rounds look at, and when they end.
struct RoundOptions {
  double bound;            // of the distance of a pair, in the target's unit of length
  double fine;             // as Stage::fine
  std::size_t stride = 1;  // between points that are looked at
  double min_overlap = 0;  // share of the points with a partner
};

/// Rounds to the pose that stays.
/// @param rounds_left  counts down
/// @return the last solution, if there was one with pairs enough
std::optional<PoseEstimate> converge(NeighbourRounds& rounds, Eigen::Isometry3d T,
                                     const RoundOptions& options, int& rounds_left) {
  constexpr std::size_t kMinPairs = 6;
  std::optional<PoseEstimate> best;
  while (rounds_left > 0) {
    const std::size_t pairs = rounds.pair_up(T, options.bound, options.stride).size();
    if (pairs < kMinPairs || rounds.overlap() < options.min_overlap) return best;
    PoseEstimate estimate = rounds.solve();
    if (estimate.status == Status::kDegenerate) return best;
    --rounds_left;
    const Eigen::Vector3d at = weighted_means(rounds.pairs(), {}).source;
    const bool settled = stays(T, estimate.T_target_source, at, options.bound, options.fine);
    T = estimate.T_target_source;
    best = std::move(estimate);
    if (settled) break;
  }
  return best;
}

struct Refined {
  Eigen::Isometry3d T;
  double bound;  // the last that left enough of the pairs
};

/// All stages from a pose.
std::optional<Refined> refine_in_stages(NeighbourRounds& rounds, const Eigen::Isometry3d& T,
                                        const CloudOptions& options,
                                        CloudRegistration& registration) {
  std::optional<Refined> refined;
  double min_overlap = 0;
  int rounds_left = options.features.refinements;
  for (const Stage& stage : kStages) {
    const double bound = stage.narrowing * registration.noise_bound;
    const auto next = converge(
        rounds, refined ? refined->T : T,
        {bound, stage.fine, stride_of(stage, rounds.source_size()), min_overlap}, rounds_left);
    if (!next) break;
    refined = {next->T_target_source, bound};
    if (stage.narrowing == 1) registration.overlap = rounds.overlap();
    // A bound that leaves few of the pairs is below the distance between the points.
    min_overlap = rounds.overlap() / 2;
  }
  registration.refinements += options.features.refinements - rounds_left;
  return refined;
}

/// Nearest neighbours also end in wrong turns about an axis that the surface is nearly round about:
/// the best of several starts about it.
/// @return nothing if that is the pose given
std::optional<Eigen::Isometry3d> turned_about_weak_axis(NeighbourRounds& rounds,
                                                        const Eigen::Isometry3d& T, double bound,
                                                        const AllowedTurns& turns) {
  constexpr int kStarts = 12, kRounds = 10;
  constexpr std::size_t kPoints = 1000;
  constexpr double kBetter = 0.9;
  const auto axis = weak_rotation(rounds.pairs(), T, turns);
  if (!axis) return std::nullopt;
  const std::size_t stride = std::max<std::size_t>(1, rounds.source_size() / kPoints);
  const auto cost_at = [&](const Eigen::Isometry3d& at) {
    rounds.pair_up(at, bound, stride);
    return rounds.truncated_cost(at, bound);
  };
  double least = kBetter * cost_at(T);
  std::optional<Eigen::Isometry3d> best;
  for (int k = 1; k < kStarts; ++k) {
    const Eigen::AngleAxisd turn(2 * std::numbers::pi * k / kStarts, axis->direction);
    const Eigen::Isometry3d about =
        Eigen::Translation3d(axis->point) * turn * Eigen::Translation3d(-axis->point);
    int rounds_left = kRounds;
    const auto end = converge(rounds, about * T, {bound, kStages[0].fine, stride}, rounds_left);
    if (!end) continue;
    const double cost = cost_at(end->T_target_source);
    if (cost >= least) continue;
    least = cost;
    best = end->T_target_source;
  }
  return best;
}

/// By how much the inverse information understates the covariance: residuals of neighbours are not
/// independent, as their normals were fitted to the same points, and the last bound cuts off some
/// of their variance.
/// @param rounds  paired up within the bound at the end
double covariance_factor(NeighbourRounds& rounds, const Refined& refined,
                         const CloudOptions& options, double noise_bound) {
  const auto mean_square = [&] {
    double sum = 0;
    for (const double r2 :
         squared_residuals(rounds.pairs(), refined.T, options.registration.primitive)) {
      sum += r2;
    }
    return sum / static_cast<double>(std::max<std::size_t>(1, rounds.pairs().size()));
  };
  rounds.pair_up(refined.T, noise_bound, 1);
  const double full = mean_square();
  rounds.pair_up(refined.T, refined.bound, 1);
  const double cut = mean_square();
  return options.features.normal_neighbours * (cut > 0 ? std::max(1.0, full / cut) : 1.0);
}

void report(const PoseEstimate& best, const NeighbourRounds& rounds, const CloudOptions& options,
            CloudRegistration& registration) {
  RegistrationResult& result = registration.result;
  registration.correspondences = rounds.pairs();
  const std::size_t count = registration.correspondences.size();
  result.weights.assign(count, 1);
  result.inliers.clear();
  for (std::size_t i = 0; i < count; ++i) result.inliers.push_back(static_cast<int>(i));
  PoseEstimate estimate = best;
  auto free = free_motions_of_overlap(registration.correspondences, best.T_target_source,
                                      options.registration.turns());
  if (!free.empty()) {
    estimate.status = Status::kDegenerate;
    estimate.rank = 6 - static_cast<int>(free.size());
    estimate.free_motions = std::move(free);
  }
  report_final_solve(estimate, registration.correspondences, options.registration.primitive,
                     options.registration.turns(), result);
  registration.rms_error =
      std::sqrt(best.cost / static_cast<double>(std::max<std::size_t>(1, count)));
}

/// Whether the residuals are rather those of noise, a quarter of the bound an axis, than of
/// surfaces that cross each other at random, uniform within the bound.
bool fits(const CloudRegistration& registration, Primitive primitive) {
  const bool plane = primitive == Primitive::kPlane;
  const double noise = plane ? 0.25 : 0.25 * std::numbers::sqrt3;
  const double random = plane ? 1 / std::numbers::sqrt3 : std::sqrt(0.6);
  return registration.rms_error < (noise + random) / 2 * registration.noise_bound;
}

/// Share of the surface within reach that contradicts the pose, the smaller of both clouds': parts
/// of one surface lie on one another wherever they meet, but for what one of them alone has seen,
/// while surfaces of two things that touch in a patch part beyond it.
/// @param rounds  of the source
double contradiction_of(const NeighbourRounds& rounds, const PointCloud& source,
                        const PointCloud& target, const Eigen::Isometry3d& T, double bound) {
  constexpr std::size_t kPoints = 1500;
  const auto stride = [](std::size_t size) { return std::max<std::size_t>(1, size / kPoints); };
  const double of_source = rounds.share_off_surface(T, bound, stride(source.size()));
  if (of_source <= kMaxContradiction) return of_source;
  const NeighbourRounds others(target, source, Primitive::kPoint, {}, 1);
  return std::min(of_source, others.share_off_surface(T.inverse(), bound, stride(target.size())));
}

/// Of a thousand points or so.
std::size_t sample_stride(const geometry::PointView& cloud) {
  constexpr std::size_t kLooked = 1000;
  return std::max<std::size_t>(1, cloud.size() / kLooked);
}

Eigen::Vector3d median_point(const geometry::PointView& cloud) {
  const std::size_t stride = sample_stride(cloud);
  Eigen::Vector3d center;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (std::size_t i = 0; i < cloud.size(); i += stride) values.push_back(cloud.point(i)[axis]);
    center[axis] = median(values);
  }
  return center;
}

/// T, or a half turn of the source about a principal axis if that fits better.
Eigen::Isometry3d best_half_turn(const PointCloud& source, const PointCloud& target,
                                 const Eigen::Isometry3d& T, double bound,
                                 const CloudOptions& options) {
  const auto better =
      better_fitting(source, target, T, turned_about_axes(source, T, 2), bound, options);
  return better ? better->T_target_source : T;
}

/// Withdraws the pose.
void refuse(RegistrationResult& result) {
  result.status = RegistrationStatus::kNoConsensus;
  result.T_target_source.reset();
  result.runner_up.reset();
}

}  // namespace

double standard_errors(const std::vector<double>& costs, const std::vector<double>& others,
                       int neighbours) {
  const auto count = static_cast<double>(costs.size());
  double mean = 0, variance = 0;
  for (std::size_t i = 0; i < costs.size(); ++i) mean += (costs[i] - others[i]) / count;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const double off = costs[i] - others[i] - mean;
    variance += off * off / count;
  }
  return variance > 0 ? mean / std::sqrt(variance * neighbours / count) : 0;
}

std::optional<Eigen::Isometry3d> settled(NeighbourRounds& rounds, const Eigen::Isometry3d& T,
                                         double bound, int most) {
  const auto end = converge(rounds, T, {bound, kStages[0].fine}, most);
  if (!end) return std::nullopt;
  return end->T_target_source;
}

std::optional<PointCloud> without_far_points(const geometry::PointView& cloud) {
  constexpr double kFar = 1000;
  if (cloud.size() < 3) return std::nullopt;
  const Eigen::Vector3d center = median_point(cloud);
  const std::size_t stride = sample_stride(cloud);
  std::vector<double> distances;
  for (std::size_t i = 0; i < cloud.size(); i += stride) {
    distances.push_back((cloud.point(i) - center).lpNorm<Eigen::Infinity>());
  }
  const double limit = kFar * median(distances);
  if (!(limit > 0)) return std::nullopt;
  const auto is_far = [&](std::size_t i) {
    return (cloud.point(i) - center).lpNorm<Eigen::Infinity>() > limit;
  };
  std::size_t first = 0;
  while (first < cloud.size() && !is_far(first)) ++first;
  if (first == cloud.size()) return std::nullopt;
  PointCloud kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (is_far(i)) continue;
    kept.points.push_back(cloud.point(i));
    if (cloud.has_normals()) kept.normals.push_back(cloud.normal(i));
  }
  return kept;
}

PointCloud thinned(const geometry::PointView& cloud) {
  constexpr std::size_t kMost = 10000;
  const double cell = voxel_cell_for(cloud, kMost);
  return cell > 0 ? geometry::voxel_sampled(cloud, cell) : geometry::copied(cloud);
}

void add_normals(PointCloud& cloud, const FeatureOptions& options, int threads) {
  if (cloud.has_normals() || cloud.size() < 3) return;
  cloud = geometry::with_plane_normals(std::move(cloud), options.normal_neighbours, threads,
                                       geometry::CollinearPoints::kDrop);
}

void refine_clouds(const PointCloud& source, const PointCloud& target, const CloudOptions& options,
                   CloudRegistration& registration) {
  const double start = now();
  const AllowedTurns turns = options.registration.turns();
  NeighbourRounds rounds(source, target, options.registration.primitive, turns, options.threads);
  auto refined =
      refine_in_stages(rounds, *registration.result.T_target_source, options, registration);
  if (refined) {
    const auto T = turned_about_weak_axis(rounds, refined->T, registration.noise_bound, turns);
    if (T) refined = refine_in_stages(rounds, *T, options, registration);
  }
  if (refined) {
    const double factor = covariance_factor(rounds, *refined, options, registration.noise_bound);
    report(rounds.solve(), rounds, options, registration);
    registration.result.covariance *= factor;
  }
  const bool degenerate = refined && !registration.result.T_target_source;
  if (!degenerate && (!refined || !fits(registration, options.registration.primitive))) {
    refuse(registration.result);
  }
  if (const auto& T = registration.result.T_target_source) {
    registration.contradiction =
        contradiction_of(rounds, source, target, *T, registration.noise_bound);
    const bool refused = registration.contradiction > kMaxContradiction;
    if (refused && !options.registration.best_effort) refuse(registration.result);
  }
  registration.result.solve_seconds += now() - start;
}

PointCloud mirror_image(PointCloud cloud) {
  for (auto* list : {&cloud.points, &cloud.normals}) {
    for (auto& p : *list) p.x() = -p.x();
  }
  return cloud;
}

void refuse_if_mirrored(const PointCloud& source, const PointCloud& target,
                        const Eigen::Isometry3d& T_mirrored,
                        const std::optional<Eigen::Isometry3d>& T_without,
                        const CloudOptions& options, CloudRegistration& registration) {
  constexpr double kDeviations = 3;
  RegistrationResult& result = registration.result;
  if (result.status == RegistrationStatus::kDegenerate) return;
  const double start = now(), reach = registration.noise_bound;
  const double bound = kStages[std::size(kStages) - 1].narrowing * reach;
  const PointCloud mirrored = mirror_image(source);
  const Primitive primitive = options.registration.primitive;
  NeighbourRounds rounds(mirrored, target, primitive, {}, options.threads);
  CloudRegistration other;
  other.noise_bound = reach;
  const Eigen::Isometry3d start_pose = best_half_turn(mirrored, target, T_mirrored, reach, options);
  const auto refined = refine_in_stages(rounds, start_pose, options, other);
  if (refined) {
    const std::vector<double> costs = rounds.truncated_costs(refined->T, reach, bound);
    std::vector<double> own(source.size(), 1);
    const auto T_own = result.T_target_source ? result.T_target_source : T_without;
    if (T_own) {
      own = NeighbourRounds(source, target, primitive, {}, options.threads)
                .truncated_costs(*T_own, reach, bound);
    }
    result.mirrored = standard_errors(own, costs, options.features.normal_neighbours) > kDeviations;
    if (result.mirrored) refuse(result);
  }
  result.solve_seconds += now() - start;
}

}  // namespace palpate::registration
