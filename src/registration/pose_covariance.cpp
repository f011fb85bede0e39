// SPDX-License-Identifier: Apache-2.0
#include "registration/pose_covariance.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "palpate/core/se3.hpp"
#include "palpate/registration/quadratic_form.hpp"
#include "registration/limited_rotation.hpp"

namespace palpate::registration {
namespace {

/// What the weights of the inliers make of least squares.
struct WeightedFit {
  double freedom = 0;          ///< of the weighted sum of squares, as of so many equal residuals
  double trace = 0;            ///< that sum over the residuals' variance, on average
  Eigen::MatrixXd covariance;  ///< over the variance, of the allowed twists
};

std::vector<double> inlier_weights(const RegistrationResult& result) {
  std::vector<double> weights;
  for (const int i : result.inliers) {
    weights.push_back(result.weights[static_cast<std::size_t>(i)]);
  }
  return weights;
}

/// For weights that may differ: the sum of squares of residuals e with weights W is e'A e with
/// A = W - W J I^-1 J'W, distributed nearly as with (tr A)^2 / tr A^2 degrees of freedom
/// (Satterthwaite 1946).
/// @param sum_of_forms  sum of w^n J'J for n
/// @param sums  of w^n over the residuals, n = 0..2
WeightedFit weighted_fit(const std::function<Eigen::MatrixXd(int)>& sum_of_forms,
                         const double (&sums)[3]) {
  const Eigen::MatrixXd inverse = sum_of_forms(1).inverse();
  const Eigen::MatrixXd squares = inverse * sum_of_forms(2), cubes = inverse * sum_of_forms(3);
  const double trace = sums[1] - squares.trace();
  const double of_square = sums[2] - 2 * cubes.trace() + (squares * squares).trace();
  return {trace * trace / of_square, trace, squares * inverse};
}

WeightedFit fit_of(const PoseEstimate& estimate, const Correspondences& correspondences,
                   Primitive primitive, const Eigen::Matrix<double, 6, Eigen::Dynamic>& twists,
                   const RegistrationResult& result) {
  const std::vector<double> weights = inlier_weights(result);
  double sums[3] = {};
  for (const double w : weights) {
    for (int n = 0; n < 3; ++n)
      sums[n] += (primitive == Primitive::kPoint ? 3 : 1) * std::pow(w, n);
  }
  const Eigen::MatrixXd information = twists.transpose() * estimate.centred_information * twists;
  if (std::ranges::all_of(weights, [&](double w) { return w == weights.front(); })) {
    const double freedom = sums[0] - static_cast<double>(twists.cols());
    return {freedom, freedom, information.inverse()};
  }
  const Correspondences inliers = subset(correspondences, result.inliers);
  const auto sum_of_forms = [&](int n) -> Eigen::MatrixXd {
    if (n == 1) return information;
    std::vector<double> powers = weights;
    for (double& w : powers) w = std::pow(w, n);
    return twists.transpose() *
           information_matrix(inliers, powers, primitive, estimate.T_target_source,
                              estimate.center) *
           twists;
  };
  return weighted_fit(sum_of_forms, sums);
}

}  // namespace

Matrix6d pose_covariance(const PoseEstimate& estimate, const Correspondences& correspondences,
                         Primitive primitive, const AllowedTurns& turns,
                         const RegistrationResult& result) {
  const auto twists = allowed_twists(turns);
  const WeightedFit fit = fit_of(estimate, correspondences, primitive, twists, result);
  // That of Student's distribution: with few residuals their variance is itself uncertain.
  if (!(fit.freedom > 2)) return Matrix6d::Constant(std::numeric_limits<double>::infinity());
  const double variance = result.cost / (fit.trace / fit.freedom * (fit.freedom - 2));
  constexpr double kMinShare = 0.25;
  const double right = 1 - result.false_inliers / static_cast<double>(result.inliers.size());
  const double share = std::max(kMinShare, right);
  Matrix6d to_origin = Matrix6d::Identity();
  to_origin.bottomLeftCorner<3, 3>() = skew(estimate.center);
  const Eigen::MatrixXd moved = to_origin * twists;
  return variance / (share * share) * moved * fit.covariance * moved.transpose();
}

}  // namespace palpate::registration
