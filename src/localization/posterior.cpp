// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/posterior.hpp"

#include <algorithm>
#include <numbers>

#include "localization/likelihood/goodness_of_fit.hpp"
#include "localization/search/pose_family.hpp"

namespace palpate::localization {

std::string_view to_string(PoseStatus status) {
  switch (status) {
    case PoseStatus::certain:
      return "certain";
    case PoseStatus::ambiguous:
      return "ambiguous";
    case PoseStatus::no_pose:
      return "no_pose";
  }
  return "unknown";
}

double Posterior::residual_mass() const {
  double listed = 0;
  for (const Mode& mode : modes) listed += mode.weight;
  return std::max(0.0, 1 - listed);
}

PoseError pose_error(const Eigen::Isometry3d& estimate, const Eigen::Isometry3d& truth,
                     const std::vector<Eigen::Matrix3d>& symmetries) {
  const PoseFamily family{PosePoint(estimate)};
  return family.match(PosePoint(truth), SymmetryGroup(symmetries)).error;
}

PoseError mode_error(const Mode& mode, const Eigen::Isometry3d& truth,
                     const std::vector<Eigen::Matrix3d>& symmetries) {
  return family_of(mode).match(PosePoint(truth), SymmetryGroup(symmetries)).error;
}

bool within(const PoseError& error, const PoseTolerance& tolerance) {
  return error.rotation < tolerance.rotation && error.translation < tolerance.translation;
}

Matrix6d family_covariance(const Mode& mode) {
  if (!mode.free_axis) return mode.covariance;
  return covariance_along(mode, mode.free_axis->extent / std::numbers::sqrt3);
}

double pose_probability(const Mode& mode) {
  if (!mode.free_axis) return mode.weight;
  const double even = std::min(1.0, PoseTolerance{}.rotation / mode.free_axis->extent);
  return mode.weight * mode.free_axis->share.value_or(even);
}

double best_probability(const Posterior& posterior) {
  return posterior.modes.empty() ? 0 : pose_probability(posterior.modes.front());
}

Posterior weighted(Posterior posterior, double probability) {
  for (Mode& mode : posterior.modes) mode.weight *= probability;
  posterior.credible_mass *= probability;
  posterior.status = status_of(posterior.modes);
  return posterior;
}

bool covers(const Posterior& posterior, const Eigen::Isometry3d& truth,
            const std::vector<Eigen::Matrix3d>& symmetries) {
  const SymmetryGroup copies(symmetries);
  double covered = 0;
  for (const Mode& mode : posterior.modes) {
    if (covered >= kCredible) break;
    if (family_of(mode).contains(PosePoint(truth), copies)) return true;
    covered += mode.weight;
  }
  return false;
}

bool truth_in_credible_set(const Posterior& posterior, const Eigen::Isometry3d& truth,
                           const std::vector<Eigen::Matrix3d>& symmetries) {
  if (covers(posterior, truth, symmetries)) return true;
  if (posterior.residual_mass() <= 1 - kCredible) return false;
  const SymmetryGroup copies(symmetries);
  return std::ranges::any_of(posterior.residual_set, [&](const Eigen::Isometry3d& center) {
    return PoseFamily(PosePoint(center)).contains(PosePoint(truth), copies);
  });
}

}  // namespace palpate::localization
