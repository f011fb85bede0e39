// SPDX-License-Identifier: Apache-2.0
#include "registration/thin_axes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace palpate::registration {
namespace {

/// Axes of points, the one that they are longest in first, and how far they reach along these.
struct Shape {
  Eigen::Matrix3d axes;
  Eigen::Vector3d lengths;

  /// How much longer they are along one axis than along the next.
  double step(int axis) const { return lengths[axis] / std::max(1e-9, lengths[axis + 1]); }
};

/// Of some of the points.
Shape shape_of(const Eigen::ArrayXf (&points)[3], int count) {
  constexpr int kSomePairs = 200;
  const int step = std::max(1, count / kSomePairs);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  double looked = 0;
  for (int i = 0; i < count; i += step, ++looked) {
    const Eigen::Vector3d p = at(points, i).cast<double>();
    mean += p;
    moment.noalias() += p * p.transpose();
  }
  mean /= looked;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moment / looked -
                                                              mean * mean.transpose());
  return {solver.eigenvectors().rowwise().reverse(),
          solver.eigenvalues().reverse().cwiseMax(0).cwiseSqrt()};
}

}  // namespace

std::vector<ThinAxes> thin_axes(const PairColumns& columns) {
  constexpr double kThin = 3;
  const Shape from = shape_of(columns.s, columns.size()), to = shape_of(columns.t, columns.size());
  std::vector<ThinAxes> axes;
  const auto add = [&](int axis) { axes.push_back({from.axes.col(axis), to.axes.col(axis)}); };
  if (std::min(from.step(0), to.step(0)) > kThin) add(0);
  if (std::min(from.step(1), to.step(1)) > kThin) add(2);
  return axes;
}

}  // namespace palpate::registration
