// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/pose.hpp"

#include <fmt/format.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "registration/certificate.hpp"
#include "registration/check_weights.hpp"
#include "registration/limited_rotation.hpp"
#include "registration/nearest_rotation.hpp"

namespace palpate::registration {
namespace {

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

/// Of a twist [w; v] about the origin, [w; v + w x center].
Matrix6d about_origin(const Matrix6d& about_center, const Eigen::Vector3d& center) {
  Matrix6d shift = Matrix6d::Identity();
  shift.bottomLeftCorner<3, 3>() = -skew(center);
  return shift.transpose() * about_center * shift;
}

/// The status that follows from bound and rank.
void conclude(PoseEstimate& estimate, double trace, const PoseOptions& options) {
  estimate.reference = std::max(estimate.cost, trace / 10);
  // A cost too large for its number is above any optimum.
  const bool proven = std::isfinite(estimate.bound) &&
                      estimate.bound <= options.rotation.relative_gap * estimate.reference;
  estimate.status = estimate.rank < 6 ? Status::kDegenerate
                    : proven          ? Status::kCertified
                                      : Status::kUncertified;
}

/// Information, rank and the status that follows from bound and rank.
void assess(PoseEstimate& estimate, const Problem& problem, const Correspondences& correspondences,
            const std::vector<double>& weights, Primitive primitive, const AllowedTurns& turns,
            const PoseOptions& options) {
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
  // Arms that are only rounding errors of the coordinates are none.
  const bool point = squared_arm <= 1e-24 * squared_size;
  CentredInformation about{.information = about_center,
                           .center = center,
                           .squared_arm = point || !(sum > 0) ? 0 : squared_arm / sum,
                           .weight_sum = sum};
  exclude_turns(about, excluded_turns(turns));
  estimate.free_motions = free_motions(about, options.rank_tolerance);
  estimate.rank = 6 - static_cast<int>(estimate.free_motions.size());
  estimate.information = about_origin(about_center, center);
  estimate.centred_information = about_center;
  estimate.center = center;
  conclude(estimate, problem.marginal.objective.trace(), options);
}

}  // namespace

std::string_view to_string(Status status) {
  switch (status) {
    case Status::kCertified:
      return "certified";
    case Status::kUncertified:
      return "uncertified";
    case Status::kDegenerate:
      break;
  }
  return "degenerate";
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
  assess(estimate, problem, correspondences, weights, primitive, {}, options);
  return estimate;
}

PoseEstimate solve_pose(const Correspondences& correspondences, const std::vector<double>& weights,
                        Primitive primitive, const AllowedTurns& turns,
                        const PoseOptions& options) {
  if (turns.all()) return solve_pose(correspondences, weights, primitive, options);
  check(correspondences, primitive);
  check_weights(weights, correspondences.size());
  const Problem problem(correspondences, weights, primitive);
  PoseEstimate estimate;
  estimate.T_target_source =
      problem.uncentred(solve_limited_rotation(problem.marginal.objective, turns));
  estimate.cost = problem.cost(estimate.T_target_source);
  assess(estimate, problem, correspondences, weights, primitive, turns, options);
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
  assess(estimate, problem, correspondences, weights, primitive, {}, options);
  return estimate;
}

namespace {

/// Sum of w (target - mean) (source - mean)'.
Eigen::Matrix3d cross_covariance(const Correspondences& correspondences,
                                 const std::vector<double>& weights, const Origins& means) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    const double w = weights.empty() ? 1 : weights[i];
    if (w == 0) continue;
    covariance.noalias() += w * (correspondences.target[i] - means.target) *
                            (correspondences.source[i] - means.source).transpose();
  }
  return covariance;
}

Eigen::Isometry3d pose_about_means(const Eigen::Matrix3d& R, const Origins& means) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R;
  T.translation() = means.target - R * means.source;
  return T;
}

}  // namespace

Eigen::Isometry3d align_points(const Correspondences& correspondences,
                               const std::vector<double>& weights) {
  const Origins means = weighted_means(correspondences, weights);
  return pose_about_means(nearest_rotation(cross_covariance(correspondences, weights, means)),
                          means);
}

Eigen::Isometry3d align_points(const Correspondences& correspondences,
                               const std::vector<double>& weights, const AllowedTurns& turns) {
  if (turns.all()) return align_points(correspondences, weights);
  const Origins means = weighted_means(correspondences, weights);
  if (turns.none) return pose_about_means(Eigen::Matrix3d::Identity(), means);
  const Eigen::Matrix3d covariance = cross_covariance(correspondences, weights, means);
  return pose_about_means(rotation_about(turns.axis->normalized(), covariance), means);
}

}  // namespace palpate::registration
