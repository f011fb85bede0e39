// SPDX-License-Identifier: Apache-2.0
#include "geometry/objects/rotation_group.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/se3.hpp"

namespace palpate::geometry {
namespace {

using Rotations = std::vector<Eigen::Matrix3d>;

/// Rotation nearest to M in the Frobenius norm.
Eigen::Matrix3d project(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  return svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

/// The last element that makes a product lead out of the set; 0 if the set is closed.
std::size_t last_open_element(const Rotations& set, double match) {
  for (std::size_t last = set.size() - 1; last > 0; --last) {
    for (std::size_t i = 1; i <= last; ++i) {
      for (const Eigen::Matrix3d& product :
           {Eigen::Matrix3d(set[i] * set[last]), Eigen::Matrix3d(set[last] * set[i])}) {
        if (rotation_distance(set[nearest_rotation(set, product)], product) > match) return last;
      }
    }
  }
  return 0;
}

Rotations average(const Rotations& set) {
  Rotations averaged;
  for (const Eigen::Matrix3d& g : set) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const Eigen::Matrix3d& h : set) {
      sum += set[nearest_rotation(set, g * h)] * h.transpose();
    }
    averaged.push_back(project(sum));
  }
  return averaged;
}

}  // namespace

std::vector<Eigen::Matrix3d> rotation_grid(int count) {
  constexpr double kPhi = std::numbers::sqrt2, kPsi = 1.533751168755204288118041;
  Rotations grid;
  for (int i = 0; i < count; ++i) {
    const double s = i + 0.5, t = s / count;
    const double alpha = 2 * std::numbers::pi * s / kPhi, beta = 2 * std::numbers::pi * s / kPsi;
    const double r = std::sqrt(t), q = std::sqrt(1 - t);
    const Eigen::Quaterniond rotation(q * std::cos(beta), r * std::sin(alpha), r * std::cos(alpha),
                                      q * std::sin(beta));
    grid.push_back(rotation.toRotationMatrix());
  }
  return grid;
}

std::size_t nearest_rotation(const std::vector<Eigen::Matrix3d>& set, const Eigen::Matrix3d& R) {
  const auto overlap = [&](const Eigen::Matrix3d& other) { return other.cwiseProduct(R).sum(); };
  return static_cast<std::size_t>(std::ranges::max_element(set, {}, overlap) - set.begin());
}

std::vector<Eigen::Matrix3d> nearest_group(std::vector<Eigen::Matrix3d> elements, double match) {
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  std::erase_if(elements, [&](const auto& R) { return rotation_distance(R, identity) <= match; });
  elements.insert(elements.begin(), identity);
  while (const std::size_t open = last_open_element(elements, match)) {
    elements.erase(elements.begin() + static_cast<std::ptrdiff_t>(open));
  }
  constexpr int kRounds = 6;  // the error is squared in each
  for (int i = 0; i < kRounds; ++i) elements = average(elements);
  std::ranges::stable_sort(elements, {}, [&](const Eigen::Matrix3d& R) {
    return std::lround(1e6 * rotation_distance(R, identity));
  });
  elements.front() = identity;
  return elements;
}

}  // namespace palpate::geometry
