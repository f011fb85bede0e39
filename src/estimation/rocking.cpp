// SPDX-License-Identifier: Apache-2.0
#include "estimation/rocking.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "palpate/core/gravity.hpp"

namespace palpate::estimation {
namespace {

constexpr double kEnergy = 1e-4;    // J, that a light push spends
constexpr double kTopPush = 0.002;  // m, by which it moves the top
constexpr double kTilt = 0.05;      // rad, at which the rise is measured
constexpr double kMinRise = 1e-9;   // m
constexpr int kAxes = 12;           // that are tried at first, over a half turn
constexpr double kFinest = 0.004;   // rad, to which the softest is sought

/// An object that rests on a plane, in axes about its centroid of which the last is up.
struct Resting {
  std::vector<Eigen::Vector3d> points;
  double weight;     // N
  double low, tall;  // m, of the centroid and of the whole over the plane
};

/// Height of the centroid over the lowest point, tilted about a horizontal axis.
double height(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& axis,
              double angle) {
  const Eigen::RowVector3d up = Eigen::AngleAxisd(angle, axis).toRotationMatrix().row(2);
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& point : points) lowest = std::min(lowest, up.dot(point));
  return -lowest;
}

Resting make_resting(const geometry::KnownObject& object, const Eigen::Matrix3d& R_table_object) {
  Resting resting{{}, object.mass * kGravity, 0, 0};
  double top = 0;
  for (const auto& vertex : object.mesh.vertices) {
    resting.points.push_back(R_table_object * vertex);
    top = std::max(top, resting.points.back().z());
  }
  resting.low = height(resting.points, Eigen::Vector3d::UnitX(), 0);
  resting.tall = resting.low + top;
  return resting;
}

Eigen::Vector3d horizontal(double angle) { return {std::cos(angle), std::sin(angle), 0}; }

/// rad, to either side whichever is easier
double tilt_about(const Resting& resting, const Eigen::Vector3d& axis) {
  const double rise =
      std::min(height(resting.points, axis, kTilt), height(resting.points, axis, -kTilt)) -
      resting.low;
  const double energy = resting.weight * std::max(rise, kMinRise);
  return std::min(kTilt * kEnergy / energy, kTopPush / resting.tall);
}

/// Direction of the horizontal axis about which it tilts farthest: a round object rolls about none
/// but its own.
double softest_axis(const Resting& resting) {
  const auto tilt = [&](double angle) { return tilt_about(resting, horizontal(angle)); };
  double softest = 0, most = 0;
  const auto consider = [&](double angle) {
    const double reached = tilt(angle);
    if (reached <= most) return;
    most = reached;
    softest = angle;
  };
  double step = std::numbers::pi / kAxes;
  for (int i = 0; i < kAxes; ++i) consider(i * step);
  while (step > kFinest) {
    step /= 2;
    const double middle = softest;
    consider(middle - step);
    consider(middle + step);
  }
  return softest;
}

}  // namespace

Matrix6d rocking_covariance(const geometry::KnownObject& object,
                            const Eigen::Isometry3d& T_frame_object, const Eigen::Vector3d& up) {
  const Eigen::Matrix3d R_frame_table =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up).toRotationMatrix();
  const Resting resting = make_resting(object, R_frame_table.transpose() * T_frame_object.linear());
  const double softest = softest_axis(resting);
  Matrix6d covariance = Matrix6d::Zero();
  for (const double angle : {softest, softest + 0.5 * std::numbers::pi}) {
    Vector6d tilt;
    tilt.head<3>() = R_frame_table * horizontal(angle);
    tilt.tail<3>() = tilt.head<3>().cross(resting.low * up);
    const double sigma = tilt_about(resting, horizontal(angle));
    covariance += sigma * sigma * tilt * tilt.transpose();
  }
  return covariance;
}

}  // namespace palpate::estimation
