// SPDX-License-Identifier: Apache-2.0
#include "registration/limited_rotation.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "palpate/core/se3.hpp"

namespace palpate::registration {
namespace {

/// The cost of turning by an angle, x' Q x with x = (cos, sin, 1).
struct AngularCost {
  Eigen::Matrix3d Q;

  static Eigen::Vector3d at(double angle) { return {std::cos(angle), std::sin(angle), 1}; }
  double value(double angle) const { return at(angle).dot(Q * at(angle)); }
  double slope(double angle) const {
    const Eigen::Vector3d along(-std::sin(angle), std::cos(angle), 0);
    return 2 * along.dot(Q * at(angle));
  }
};

/// R = (I - a a') cos + [a] sin + a a', so that r~ is linear in (cos, sin, 1).
AngularCost angular_cost(const Matrix10d& objective, const Eigen::Vector3d& axis) {
  const Eigen::Matrix3d along = axis * axis.transpose();
  Eigen::Matrix<double, 10, 3> basis;
  basis << homogeneous(Eigen::Matrix3d(Eigen::Matrix3d::Identity() - along)),
      homogeneous(Eigen::Matrix3d(skew(axis))), homogeneous(along);
  basis.row(9) << 0, 0, 1;
  return {basis.transpose() * objective * basis};
}

/// Where the slope turns from falling to rising, by halving.
double minimum_between(const AngularCost& cost, double low, double high) {
  constexpr int kHalvings = 50;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (cost.slope(middle) < 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Of at most two minima, which lie in different steps unless they are nearly one.
double best_angle(const AngularCost& cost) {
  constexpr int kSteps = 64;
  constexpr double kStep = 2 * std::numbers::pi / kSteps;
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kSteps; ++k) {
    if (cost.slope(k * kStep) >= 0 || cost.slope((k + 1) * kStep) < 0) continue;
    const double angle = minimum_between(cost, k * kStep, (k + 1) * kStep);
    if (cost.value(angle) >= least) continue;
    least = cost.value(angle);
    best = angle;
  }
  return best;
}

}  // namespace

Eigen::Matrix3d solve_limited_rotation(const Matrix10d& objective, const AllowedTurns& turns) {
  if (!turns.axis) return Eigen::Matrix3d::Identity();
  const Eigen::Vector3d axis = turns.axis->normalized();
  return Eigen::AngleAxisd(best_angle(angular_cost(objective, axis)), axis).toRotationMatrix();
}

Eigen::Matrix3d excluded_turns(const AllowedTurns& turns) {
  if (turns.all()) return Eigen::Matrix3d::Zero();
  if (!turns.axis) return Eigen::Matrix3d::Identity();
  const Eigen::Vector3d axis = turns.axis->normalized();
  return Eigen::Matrix3d::Identity() - axis * axis.transpose();
}

Eigen::Matrix<double, 6, Eigen::Dynamic> allowed_twists(const AllowedTurns& turns) {
  if (turns.all()) return Matrix6d::Identity();
  const Eigen::Index turning = turns.axis ? 1 : 0;
  Eigen::Matrix<double, 6, Eigen::Dynamic> basis(6, turning + 3);
  basis.setZero();
  basis.bottomRightCorner<3, 3>().setIdentity();
  if (turns.axis) basis.col(0).head<3>() = turns.axis->normalized();
  return basis;
}

}  // namespace palpate::registration
