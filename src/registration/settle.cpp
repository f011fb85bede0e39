// SPDX-License-Identifier: Apache-2.0
#include "registration/settle.hpp"

#include "palpate/registration/pose.hpp"

namespace palpate::registration {
namespace {

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
    if (!correspondences.weights.empty() && correspondences.weights[i] == 0) continue;
    if (distance < 1) inliers.push_back(static_cast<int>(i));
  }
  return inliers;
}

}  // namespace

std::vector<int> settle(const Correspondences& correspondences, Eigen::Isometry3d T,
                        const ConsensusOptions& options) {
  constexpr int kMaxRounds = 20;
  std::vector<int> inliers = inliers_of(correspondences, T, options);
  for (int round = 0; round < kMaxRounds && inliers.size() >= 3; ++round) {
    std::vector<double> weights(correspondences.size(), 0);
    for (const int i : inliers) {
      const auto index = static_cast<std::size_t>(i);
      weights[index] = correspondences.weights.empty() ? 1 : correspondences.weights[index];
    }
    T = align_points(correspondences, weights, options.turns);
    auto next = inliers_of(correspondences, T, options);
    const bool settled = next == inliers;
    if (next.size() < 3) break;
    inliers = std::move(next);
    if (settled) break;
  }
  return inliers;
}

}  // namespace palpate::registration
