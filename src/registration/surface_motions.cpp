// SPDX-License-Identifier: Apache-2.0
#include "registration/surface_motions.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/geometry/cloud/kd_tree.hpp"

namespace palpate::registration {
namespace {

CentredInformation surface_information(const geometry::PointCloud& cloud) {
  CentredInformation result;
  result.weight_sum = static_cast<double>(cloud.size());
  for (const auto& p : cloud.points) result.center += p / result.weight_sum;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d arm = cloud.points[i] - result.center;
    Vector6d row;
    row << arm.cross(cloud.normals[i]), cloud.normals[i];
    result.information.noalias() += row * row.transpose();
    result.squared_arm += arm.squaredNorm() / result.weight_sum;
  }
  return result;
}

}  // namespace

double normal_noise(const geometry::PointCloud& cloud) {
  constexpr int kNeighbours = 9;
  constexpr std::size_t kLooked = 500;
  const geometry::KdTree tree(cloud.points);
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / kLooked);
  std::vector<double> squares;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    const Eigen::Vector3d& n = cloud.normals[i];
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& near : tree.nearest(cloud.points[i], kNeighbours)) {
      if (near.index == static_cast<int>(i)) continue;
      const Eigen::Vector3d& m = cloud.normals[static_cast<std::size_t>(near.index)];
      sum += n.dot(m) < 0 ? Eigen::Vector3d(-m) : m;
    }
    if (sum.norm() > 0) squares.push_back((n - sum.normalized()).squaredNorm());
  }
  if (squares.empty()) return 0;
  std::ranges::nth_element(squares,
                           squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2));
  // The median of two squared normal deviates is 2 ln 2 times their variance, that of a difference
  // to the mean of eight 9/8 of one.
  const double median = squares[squares.size() / 2];
  return std::sqrt(median / (2 * std::numbers::ln2) * 8 / 9);
}

Vector6d motion_shares(const geometry::PointCloud& cloud) {
  const CentredInformation about = surface_information(cloud);
  Vector6d scale = Vector6d::Ones();
  scale.head<3>().setConstant(1 / std::sqrt(std::max(about.squared_arm, 1e-300)));
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(
             scale.asDiagonal() * about.information * scale.asDiagonal() / about.weight_sum,
             Eigen::EigenvaluesOnly)
      .eigenvalues();
}

std::vector<FreeMotion> free_surface_motions(const geometry::PointCloud& cloud) {
  // Sampling shifts points within a cell, which an even surface gets about this share of.
  constexpr double kSampling = 1e-3;
  constexpr double kDeviations = 2;  // of the noise, squared below
  // Normals that differ by more are not noisy but of walls thinner than their neighbourhood.
  constexpr double kMost = 0.2;
  const double noise = std::min(kMost, kDeviations * normal_noise(cloud));
  return free_motions(surface_information(cloud), std::max(kSampling, noise * noise));
}

}  // namespace palpate::registration
