// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/registration.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>

#include "palpate/core/error.hpp"
#include "registration/certificate.hpp"
#include "registration/clock.hpp"
#include "registration/consensus.hpp"
#include "registration/final_solve.hpp"
#include "registration/pose_covariance.hpp"
#include "registration/scale.hpp"
#include "registration/settle.hpp"
#include "registration/usable_pairs.hpp"

namespace palpate::registration {
namespace {

void check_motion(const RegistrationOptions& options) {
  if (options.instances < 1) {
    throw BadInput(fmt::format("{} instances: at least one is looked for", options.instances));
  }
  if (options.initial) {
    if (!options.initial->matrix().allFinite()) throw BadInput("the initial pose holds nan or inf");
    check_rotation(options.initial->linear());
  }
  if (!options.rotation_axis && !options.translation_only) return;
  const Eigen::Vector3d axis = options.rotation_axis.value_or(Eigen::Vector3d::UnitZ());
  if (!(axis.norm() > 0) || !std::isfinite(axis.norm())) {  // nor what is too long to be scaled
    throw BadInput(fmt::format("no rotation axis: ({}, {}, {})", axis[0], axis[1], axis[2]));
  }
  if (options.rotation_axis && options.translation_only) {
    throw BadInput("a rotation axis and translation only exclude one another");
  }
  if (options.method == Method::kGnc) {
    throw BadInput("limits to rotation go with cliques, not with gnc");
  }
}

}  // namespace

void check(const RegistrationOptions& options) {
  if (!(options.noise_bound > 0) || !std::isfinite(options.noise_bound)) {
    throw BadInput(fmt::format("noise bound {} m is not positive", options.noise_bound));
  }
  if (!(options.normal_noise_deg >= 0 && options.normal_noise_deg <= 90)) {
    throw BadInput(
        fmt::format("normal noise {} deg is not within 0..90", options.normal_noise_deg));
  }
  if (!(options.max_false_alarms > 0)) {
    throw BadInput(
        fmt::format("{} tolerated false alarms: not positive", options.max_false_alarms));
  }
  check_motion(options);
}

namespace {

/// Share of the information below which a direction is free: what noise alone gives to lever arms
/// (twice its standard deviation, a quarter of the bound) and to normals.
double rank_tolerance(const Correspondences& inliers, const RegistrationOptions& options) {
  const Origins means = weighted_means(inliers, {});
  double squared_arm = 0;
  for (const auto& p : inliers.source) squared_arm += (p - means.source).squaredNorm();
  squared_arm /= std::max(1.0, static_cast<double>(inliers.size()));
  double tolerance = PoseOptions{}.rank_tolerance;
  if (squared_arm > 0) {
    tolerance = std::max(tolerance, options.noise_bound * options.noise_bound / (4 * squared_arm));
  }
  if (options.primitive == Primitive::kPlane) {
    const double noise = options.normal_noise_deg * std::numbers::pi / 180;
    tolerance = std::max(tolerance, noise * noise);
  }
  return tolerance;
}

/// Fills in the final solve for the inliers.
void solve(const Correspondences& correspondences, const RegistrationOptions& options,
           RegistrationResult& result) {
  const Correspondences inliers = subset(correspondences, result.inliers);
  PoseOptions pose_options;
  pose_options.rank_tolerance = rank_tolerance(inliers, options);
  std::vector<double> weights;
  for (const int i : result.inliers) {
    weights.push_back(result.weights[static_cast<std::size_t>(i)]);
  }
  const PoseEstimate estimate =
      solve_pose(inliers, weights, options.primitive, options.turns(), pose_options);
  report_final_solve(estimate, correspondences, options.primitive, options.turns(), result);
}

ConsensusOptions consensus_options(const Correspondences& correspondences,
                                   const RegistrationOptions& options) {
  return {.noise_bound = options.noise_bound,
          .normal_noise_deg = correspondences.has_normals() ? options.normal_noise_deg : 0,
          .max_false_alarms = options.max_false_alarms,
          .best_effort = options.best_effort,
          .support_radius = options.support_radius,
          .turns = options.turns()};
}

/// Weights and inliers of a consensus among all pairs.
/// @param sampled  share of the pairs that were searched
void adopt(const Consensus& consensus, const Correspondences& correspondences, double sampled,
           const ConsensusOptions& options, RegistrationResult& result) {
  result.iterations = consensus.hypotheses;
  result.false_alarms = consensus.false_alarms;
  result.mirrored = consensus.mirrored;
  if (!consensus.found) return;
  result.runner_up = consensus.runner_up;
  result.false_inliers = consensus.false_inliers / sampled;
  result.inliers = settle(correspondences, consensus.T_target_source, options);
  // Of coordinates too large for the bound in single precision nothing is left.
  if (result.inliers.size() < 3) result.false_alarms = std::numeric_limits<double>::infinity();
  for (const int i : result.inliers) {
    const auto index = static_cast<std::size_t>(i);
    result.weights[index] = correspondences.weights.empty() ? 1 : correspondences.weights[index];
  }
}

/// Weights and inliers by graduated non-convexity alone.
/// @return whether there is a consensus
bool reject_by_gnc(const Correspondences& correspondences, const Correspondences& sample,
                   const RegistrationOptions& options, const RandomStream& random,
                   RegistrationResult& result) {
  const GncResult gnc =
      graduated_non_convexity(correspondences, {.cost = options.cost,
                                                .noise_bound = options.noise_bound,
                                                .keep_history = options.keep_history});
  result.iterations = gnc.iterations;
  result.history = gnc.history;
  result.false_alarms = false_alarms_of(gnc.T_target_source, sample,
                                        consensus_options(correspondences, options), random);
  if (!options.best_effort && !(result.false_alarms < options.max_false_alarms)) return false;
  result.weights = gnc.weights;
  for (std::size_t i = 0; i < gnc.weights.size(); ++i) {
    if (gnc.weights[i] > 0.5) result.inliers.push_back(static_cast<int>(i));
    if (!correspondences.weights.empty()) result.weights[i] *= correspondences.weights[i];
  }
  return result.inliers.size() >= 3;
}

/// Rejects outliers: fills in weights, inliers, iterations and the number of false alarms.
/// @return whether there is a consensus
bool reject(const Correspondences& correspondences, const RegistrationOptions& options,
            RegistrationResult& result) {
  const RandomStream random(options.seed, "registration");
  const ConsensusOptions search = consensus_options(correspondences, options);
  const Correspondences sample = search_sample(correspondences, options.noise_bound, random);
  if (sample.size() < 3) return false;
  if (options.method == Method::kGnc) {
    return reject_by_gnc(correspondences, sample, options, random, result);
  }
  const Consensus consensus =
      options.initial
          ? refine_consensus(sample, *options.initial, options.initial_reach, search, random)
          : find_consensus(sample, search, random);
  const double sampled =
      static_cast<double>(sample.size()) / static_cast<double>(correspondences.size());
  adopt(consensus, correspondences, sampled, search, result);
  return result.inliers.size() >= 3;
}

bool all_equal(const std::vector<Eigen::Vector3d>& points) {
  return std::ranges::all_of(points, [&](const auto& p) { return p == points.front(); });
}

RegistrationResult register_rigid(const Correspondences& correspondences,
                                  const RegistrationOptions& options) {
  const double start = now();
  RegistrationResult result;
  result.weights.assign(correspondences.size(), 0);
  result.false_alarms = 1;
  if (correspondences.size() < 3 || all_equal(correspondences.source) ||
      all_equal(correspondences.target)) {
    result.status = RegistrationStatus::kDegenerate;
    return result;
  }
  const bool found = reject(correspondences, options, result);
  const double rejected = now();
  if (found) solve(correspondences, options, result);
  const double end = now();
  result.search_seconds = rejected - start;
  result.solve_seconds = end - rejected;
  return result;
}

/// Of pairs that have a pose, those near it. Inliers alone are not enough: what noise puts just
/// beyond the bound agrees on poses a little off.
std::vector<int> explained(const RegistrationResult& result, double noise_bound) {
  constexpr double kReach = 3;  // noise bounds
  std::vector<int> near;
  for (std::size_t i = 0; i < result.residuals.size(); ++i) {
    if (result.residuals[i] <= kReach * noise_bound) near.push_back(static_cast<int>(i));
  }
  return near;
}

/// Of a turn, the translation following, against a cost that differs by `bound`.
double resolution_deg(const Matrix6d& information, double bound) {
  const Eigen::Matrix3d turn = information.topLeftCorner<3, 3>(),
                        cross = information.topRightCorner<3, 3>(),
                        shift = information.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d marginal = turn - cross * shift.ldlt().solve(cross.transpose());
  const double least =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(marginal, Eigen::EigenvaluesOnly)
          .eigenvalues()[0];
  if (!(least > 0)) return 180;
  return std::min(180.0, std::sqrt(std::max(0.0, bound) / least) * 180 / std::numbers::pi);
}

double truncated_cost(const std::vector<double>& residuals, double noise_bound) {
  double sum = 0;
  for (const double r : residuals) sum += std::min(r * r, noise_bound * noise_bound);
  return sum;
}

}  // namespace

std::string_view to_string(RegistrationStatus status) {
  switch (status) {
    case RegistrationStatus::kFound:
      return "found";
    case RegistrationStatus::kNoConsensus:
      return "no_consensus";
    case RegistrationStatus::kDegenerate:
      break;
  }
  return "degenerate";
}

void report_final_solve(const PoseEstimate& estimate, const Correspondences& correspondences,
                        Primitive primitive, const AllowedTurns& turns,
                        RegistrationResult& result) {
  const bool free = estimate.status == Status::kDegenerate;
  result.status = free ? RegistrationStatus::kDegenerate : RegistrationStatus::kFound;
  result.certificate.least_squares = estimate.status == Status::kCertified;
  result.cost = estimate.cost;
  result.bound = estimate.bound;
  result.rank = estimate.rank;
  result.free_motions = estimate.free_motions;
  result.information = estimate.information;
  if (free) {
    result.T_target_source.reset();
    result.runner_up.reset();
    result.residuals.clear();
    return;
  }
  result.T_target_source = estimate.T_target_source;
  result.certificate.resolution_deg = resolution_deg(estimate.centred_information, estimate.bound);
  result.covariance = pose_covariance(estimate, correspondences, primitive, turns, result);
  result.residuals =
      squared_residuals(correspondences, estimate.T_target_source, Primitive::kPoint);
  for (double& r : result.residuals) r = std::sqrt(r);
}

void find_more(const Correspondences& correspondences, const RegistrationOptions& options,
               RegistrationResult& result) {
  std::vector<int> left(correspondences.size());
  std::iota(left.begin(), left.end(), 0);
  RegistrationResult last = result;
  std::vector<int> taken = explained(result, options.noise_bound);
  for (int k = 1; k < options.instances && last.T_target_source; ++k) {
    std::vector<int> rest;
    std::ranges::set_difference(left, taken, std::back_inserter(rest));
    left = std::move(rest);
    last = register_rigid(subset(correspondences, left), options);
    taken.clear();
    if (!last.T_target_source) break;
    for (const int i : explained(last, options.noise_bound)) {
      taken.push_back(left[static_cast<std::size_t>(i)]);
    }
    result.instances.push_back(
        {static_cast<int>(last.inliers.size()), *last.T_target_source, last.false_alarms});
  }
  std::ranges::stable_sort(result.instances, std::greater<>(), &RunnerUp::inliers);
  if (!result.instances.empty()) result.runner_up = result.instances.front();
}

void bound_robustly(const Correspondences& correspondences, const RegistrationOptions& options,
                    RegistrationResult& result) {
  if (options.robust_bound.max_nodes == 0 || !result.T_target_source) return;
  result.certificate.robust =
      bound_inliers(correspondences, options.noise_bound, static_cast<int>(result.inliers.size()),
                    options.robust_bound);
  result.certificate.robust->cost = truncated_cost(result.residuals, options.noise_bound);
}

RegistrationResult register_correspondences(const Correspondences& correspondences,
                                            const RegistrationOptions& options) {
  check(options);
  check(correspondences, options.primitive);
  if (options.estimate_scale) return register_scaled(correspondences, options);
  const double start = now();
  RegistrationResult result = register_rigid(correspondences, options);
  if (options.instances > 1) find_more(correspondences, options, result);
  bound_robustly(correspondences, options, result);
  result.seconds = now() - start;
  return result;
}

}  // namespace palpate::registration
