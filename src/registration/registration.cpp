// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/registration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/error.hpp"
#include "registration/clock.hpp"
#include "registration/consensus.hpp"
#include "registration/fill_in.hpp"

namespace palpate::registration {
namespace {

void check_options(const RegistrationOptions& options) {
  if (!(options.noise_bound > 0) || !std::isfinite(options.noise_bound)) {
    throw BadInput(fmt::format("noise bound {} m is not positive", options.noise_bound));
  }
  if (!(options.normal_noise_deg >= 0 && options.normal_noise_deg <= 90)) {
    throw BadInput(
        fmt::format("normal noise {} deg is not within 0..90", options.normal_noise_deg));
  }
  if (!(options.false_alarm > 0)) {
    throw BadInput(fmt::format("false alarm rate {} is not positive", options.false_alarm));
  }
}

/// Correspondences that the search looks at; the final inliers come from all.
Correspondences search_sample(const Correspondences& correspondences) {
  constexpr std::size_t kMost = 4000;
  const std::size_t n = correspondences.size();
  if (n <= kMost) return correspondences;
  std::vector<int> indices;
  for (std::size_t i = 0; i < kMost; ++i) indices.push_back(static_cast<int>(i * n / kMost));
  return subset(correspondences, indices);
}

/// Pairs within the bound, and with normals within the joint ball of position and chord.
std::vector<int> inliers_of(const Correspondences& correspondences, const Eigen::Isometry3d& T,
                            const ConsensusOptions& options) {
  const double bound2 = options.noise_bound * options.noise_bound;
  const double chord = chord_bound(correspondences, options.normal_noise_deg);
  const auto squared = squared_residuals(correspondences, T, Primitive::kPoint);
  std::vector<int> inliers;
  for (std::size_t i = 0; i < squared.size(); ++i) {
    double distance = squared[i] / bound2;
    if (chord > 0 && distance < 1) {
      const Eigen::Vector3d n = T.linear() * correspondences.source_normals[i];
      distance += (n - correspondences.target_normals[i]).squaredNorm() / (chord * chord);
    }
    if (distance < 1) inliers.push_back(static_cast<int>(i));
  }
  return inliers;
}

/// Inliers and least squares in turn, until the inliers stay.
std::vector<int> settle(const Correspondences& correspondences, Eigen::Isometry3d T,
                        const ConsensusOptions& options) {
  constexpr int kMaxRounds = 20;
  std::vector<int> inliers = inliers_of(correspondences, T, options);
  for (int round = 0; round < kMaxRounds && inliers.size() >= 3; ++round) {
    std::vector<double> weights(correspondences.size(), 0);
    for (const int i : inliers) weights[static_cast<std::size_t>(i)] = 1;
    T = align_points(correspondences, weights);
    auto next = inliers_of(correspondences, T, options);
    const bool settled = next == inliers;
    if (next.size() < 3) break;
    inliers = std::move(next);
    if (settled) break;
  }
  return inliers;
}

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
  const PoseEstimate estimate = solve_pose(inliers, weights, options.primitive, pose_options);
  fill_in(estimate, correspondences, result);
}

/// Rejects outliers: fills in weights, inliers, iterations and the chance of the consensus.
/// @return whether there is a consensus
bool reject(const Correspondences& correspondences, const RegistrationOptions& options,
            RegistrationResult& result) {
  const RandomStream random(options.seed, "registration");
  const bool normals = correspondences.has_normals();
  const ConsensusOptions consensus_options{
      options.noise_bound, normals ? options.normal_noise_deg : 0, options.false_alarm};
  const Correspondences sample = search_sample(correspondences);
  if (options.method == Method::kCliqueGnc) {
    const Consensus consensus = find_consensus(sample, consensus_options, random);
    result.iterations = consensus.hypotheses;
    result.expected_by_chance = consensus.expected_by_chance;
    if (!consensus.found) return false;
    result.inliers = settle(correspondences, consensus.T_target_source, consensus_options);
    for (const int i : result.inliers) result.weights[static_cast<std::size_t>(i)] = 1;
    return true;
  }
  const GncResult gnc =
      graduated_non_convexity(correspondences, {.cost = options.cost,
                                                .noise_bound = options.noise_bound,
                                                .keep_history = options.keep_history});
  result.iterations = gnc.iterations;
  result.history = gnc.history;
  result.expected_by_chance = chance_of(gnc.T_target_source, sample, consensus_options, random);
  if (!(result.expected_by_chance < options.false_alarm)) return false;
  result.weights = gnc.weights;
  for (std::size_t i = 0; i < gnc.weights.size(); ++i) {
    if (gnc.weights[i] > 0.5) result.inliers.push_back(static_cast<int>(i));
  }
  return true;
}

bool all_equal(const std::vector<Eigen::Vector3d>& points) {
  return std::ranges::all_of(points, [&](const auto& p) { return p == points.front(); });
}

}  // namespace

void fill_in(const PoseEstimate& estimate, const Correspondences& correspondences,
             RegistrationResult& result) {
  result.status = estimate.status;
  result.T_target_source = estimate.T_target_source;
  result.cost = estimate.cost;
  result.bound = estimate.bound;
  result.rank = estimate.rank;
  result.information = estimate.information;
  result.residuals =
      squared_residuals(correspondences, estimate.T_target_source, Primitive::kPoint);
  for (double& r : result.residuals) r = std::sqrt(r);
}

RegistrationResult register_correspondences(const Correspondences& correspondences,
                                            const RegistrationOptions& options) {
  check_options(options);
  check(correspondences, options.primitive);
  const double start = now();
  RegistrationResult result;
  result.weights.assign(correspondences.size(), 0);
  result.expected_by_chance = 1;
  if (correspondences.size() < 3 || all_equal(correspondences.source) ||
      all_equal(correspondences.target)) {
    result.status = Status::kDegenerate;
    return result;
  }
  const bool found = reject(correspondences, options, result);
  const double rejected = now();
  if (found) solve(correspondences, options, result);
  const double end = now();
  result.search_seconds = rejected - start;
  result.solve_seconds = end - rejected;
  result.seconds = end - start;
  return result;
}

}  // namespace palpate::registration
