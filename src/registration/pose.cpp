// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/pose.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "palpate/core/error.hpp"
#include "registration/certificate.hpp"
#include "registration/nearest_rotation.hpp"

namespace palpate::registration {
namespace {

void check_weights(const std::vector<double>& weights, std::size_t pairs) {
  if (weights.empty()) return;
  if (weights.size() != pairs) {
    throw BadInput(fmt::format("{} weights for {} correspondences", weights.size(), pairs));
  }
  for (std::size_t i = 0; i < pairs; ++i) {
    if (!(weights[i] >= 0) || !std::isfinite(weights[i])) {
      throw BadInput(fmt::format("weight {} is {}, not a number >= 0", i, weights[i]));
    }
  }
}

/// Rank of the information once lever arms are in units of their root mean square.
int motion_rank(const Matrix6d& information, double weight_sum, double squared_arm,
                double squared_size, double tolerance) {
  // Arms that are only rounding errors of the coordinates are none.
  const bool point = squared_arm <= 1e-24 * squared_size;
  Vector6d scale = Vector6d::Ones();
  scale.head<3>().setConstant(point ? 0 : 1 / std::sqrt(squared_arm));
  const Matrix6d scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Vector6d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Matrix6d>(scaled, Eigen::EigenvaluesOnly).eigenvalues();
  return static_cast<int>((eigenvalues.array() > tolerance * weight_sum).count());
}

/// The problem on centred coordinates.
struct Problem {
  Origins origins;
  Matrix13d form;
  MarginalForm marginal;

  Problem(const Correspondences& correspondences, const std::vector<double>& weights,
          Primitive primitive)
      : origins(weighted_means(correspondences, weights)),
        form(quadratic_form(correspondences, weights, primitive, origins)),
        marginal(marginalize(form)) {}

  Eigen::Isometry3d uncentred(const Eigen::Matrix3d& R) const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = R;
    T.translation() = marginal.translation * homogeneous(R) + origins.target - R * origins.source;
    return T;
  }

  double cost(const Eigen::Isometry3d& T) const {
    Eigen::Isometry3d centred = T;
    centred.translation() = T * origins.source - origins.target;
    const Vector13d tau = homogeneous(centred);
    return std::max(0.0, tau.dot(form * tau));
  }
};

/// Information, rank and the status that follows from bound and rank.
void assess(PoseEstimate& estimate, const Problem& problem, const Correspondences& correspondences,
            const std::vector<double>& weights, Primitive primitive, const PoseOptions& options) {
  const Eigen::Isometry3d& T = estimate.T_target_source;
  const Eigen::Vector3d center = T * problem.origins.source;
  double sum = 0, squared_arm = 0, squared_size = 0;
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    const double w = weights.empty() ? 1 : weights[i];
    sum += w;
    squared_arm += w * (correspondences.source[i] - problem.origins.source).squaredNorm();
    squared_size += w * correspondences.source[i].squaredNorm();
  }
  const Matrix6d about_center = information_matrix(correspondences, weights, primitive, T, center);
  if (sum > 0) {
    estimate.rank = motion_rank(about_center, sum, squared_arm / sum, squared_size / sum,
                                options.rank_tolerance);
  }
  // A twist [w; v] about the origin is [w; v + w x center] about the center.
  Matrix6d shift = Matrix6d::Identity();
  shift.bottomLeftCorner<3, 3>() = -skew(center);
  estimate.information = shift.transpose() * about_center * shift;
  estimate.reference = std::max(estimate.cost, problem.marginal.objective.trace() / 10);
  const bool proven = estimate.bound <= options.rotation.relative_gap * estimate.reference;
  estimate.status = estimate.rank < 6 ? Status::kDegenerate
                    : proven          ? Status::kCertified
                                      : Status::kUncertified;
}

}  // namespace

std::string_view to_string(Status status) {
  switch (status) {
    case Status::kCertified:
      return "certified";
    case Status::kUncertified:
      return "uncertified";
    case Status::kDegenerate:
      return "degenerate";
    case Status::kNoConsensus:
      break;
  }
  return "no_consensus";
}

PoseEstimate solve_pose(const Correspondences& correspondences, const std::vector<double>& weights,
                        Primitive primitive, const PoseOptions& options) {
  check(correspondences, primitive);
  check_weights(weights, correspondences.size());
  const Problem problem(correspondences, weights, primitive);
  const RotationEstimate rotation = solve_rotation(problem.marginal.objective, options.rotation);
  PoseEstimate estimate;
  estimate.T_target_source = problem.uncentred(rotation.R);
  estimate.cost = std::max(0.0, rotation.certificate.cost);
  estimate.bound = rotation.certificate.bound;
  assess(estimate, problem, correspondences, weights, primitive, options);
  return estimate;
}

PoseEstimate certify(const Eigen::Isometry3d& T_target_source,
                     const Correspondences& correspondences, const std::vector<double>& weights,
                     Primitive primitive, const PoseOptions& options) {
  if (!T_target_source.matrix().allFinite()) throw BadInput("the pose holds nan or inf");
  check_rotation(T_target_source.linear());
  const PoseEstimate best = solve_pose(correspondences, weights, primitive, options);
  const Problem problem(correspondences, weights, primitive);
  PoseEstimate estimate;
  estimate.T_target_source = T_target_source;
  estimate.cost = problem.cost(T_target_source);
  estimate.bound = std::max(0.0, estimate.cost - best.cost) + best.bound;
  assess(estimate, problem, correspondences, weights, primitive, options);
  return estimate;
}

Eigen::Isometry3d align_points(const Correspondences& correspondences,
                               const std::vector<double>& weights) {
  const Origins means = weighted_means(correspondences, weights);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    const double w = weights.empty() ? 1 : weights[i];
    if (w == 0) continue;
    covariance.noalias() += w * (correspondences.target[i] - means.target) *
                            (correspondences.source[i] - means.source).transpose();
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = nearest_rotation(covariance);
  T.translation() = means.target - T.linear() * means.source;
  return T;
}

}  // namespace palpate::registration
