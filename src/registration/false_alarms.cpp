// SPDX-License-Identifier: Apache-2.0
#include "registration/false_alarms.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::registration {
namespace {

constexpr int kPoseDimensions = 6;

double log_ball(double dimensions, double radius) {
  return dimensions / 2 * std::log(std::numbers::pi) - std::lgamma(dimensions / 2 + 1) +
         dimensions * std::log(radius);
}

/// Volume of the residuals of k pairs about their best pose, in k balls of radius 1 at most.
double log_residuals(int dimensions, double squares, double k) {
  const double freedom = dimensions * k - kPoseDimensions;
  return std::min(log_ball(freedom, std::sqrt(squares)),
                  freedom / dimensions * log_ball(dimensions, 1));
}

/// log of sqrt(det H_k). Points spread by less than the bound still distinguish poses by the bound.
/// What single precision leaves uncertain of a narrow cloud's inertia counts as information, which
/// makes chance more likely rather than less.
double log_information(const BackgroundModel& model, double k) {
  const Eigen::Matrix3d rotation =
      (k - 1) * (model.inertia + Eigen::Matrix3d::Identity()) + k * model.normal_information;
  constexpr double kCertain = 1e-6;
  const Eigen::Array3d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(rotation, Eigen::EigenvaluesOnly)
          .eigenvalues();
  const double least = std::max(k - 1, kCertain * eigenvalues[2]);
  return 0.5 * eigenvalues.max(least).log().sum() + 1.5 * std::log(k);
}

}  // namespace

double matching_radius(int dimensions, double squares, int count) {
  const double freedom = dimensions * count - kPoseDimensions;
  return std::clamp(std::sqrt(squares * (dimensions + 2) / freedom), kMinMatchingRadius, 1.0);
}

double matching_squares(int dimensions, double radius, int count) {
  const double freedom = dimensions * count - kPoseDimensions;
  return radius * radius * freedom / (dimensions + 2);
}

double number_of_false_alarms(const BackgroundModel& model, double squares, int count) {
  if (count <= 3 || !model.inertia.allFinite()) return std::numeric_limits<double>::infinity();
  const double k = count, log_unit = log_ball(model.dimensions, model.radius);
  const double log_poses = std::log(model.pairs * model.orientations) + log_unit +
                           (k - 1) * std::log(model.rate) + log_information(model, k);
  const double least = matching_squares(model.dimensions, kMinMatchingRadius, count);
  const double log_sets = log_residuals(model.dimensions, std::max(squares, least), k) -
                          k * log_unit - std::lgamma(k + 1);
  return std::exp(std::min(log_poses + log_sets, 700.0));
}

double grid_false_alarms(double pairs, double rate, int count) {
  const double n = pairs, k = count, mean = std::max(1.0, rate);
  if (k <= 3 || k <= mean) return std::numeric_limits<double>::infinity();
  const double log_poses = 2 * std::log(n * (n - 1) * (n - 2)) - std::log(k * (k - 1) * (k - 2));
  // The first term of the tail and a geometric series that bounds the others.
  const double log_tail =
      -mean + k * std::log(mean) - std::lgamma(k + 1) - std::log1p(-mean / (k + 1));
  return std::exp(std::min(log_poses + log_tail, 700.0));
}

double sign_test(int more, int fewer) {
  if (more <= fewer) return 1;
  const double all = more + fewer;
  double exponent = more * std::log(2 * more / all);
  if (fewer > 0) exponent += fewer * std::log(2 * fewer / all);
  return std::exp(-exponent);
}

}  // namespace palpate::registration
