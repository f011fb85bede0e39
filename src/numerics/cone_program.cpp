// SPDX-License-Identifier: Apache-2.0
#include "numerics/cone_program.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::numerics {
namespace {

constexpr double kGrowth = 15;       // of the weight of the objective, between centrings
constexpr double kCentred = 1e-9;    // half the squared Newton decrement
constexpr int kCentringSteps = 60;   // far more than a centring needs
constexpr double kSufficient = 0.1;  // share of the predicted decrease that a step must bring
constexpr double kShortest = 1e-12;

/// Value, gradient and Hessian at u of -log(u_0^2 - |u_1..|^2), summed over the cones.
struct Barrier {
  double value = 0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};

double barrier_value(const Eigen::VectorXd& u, const std::vector<int>& sizes) {
  double value = 0;
  Eigen::Index at = 0;
  for (const int size : sizes) {
    const double side = u.segment(at + 1, size - 1).norm();
    if (!(u[at] > side)) return std::numeric_limits<double>::infinity();
    value -= std::log(u[at] - side) + std::log(u[at] + side);
    at += size;
  }
  return value;
}

Barrier barrier(const Eigen::VectorXd& u, const std::vector<int>& sizes) {
  Barrier result{barrier_value(u, sizes), Eigen::VectorXd(u.size()),
                 Eigen::MatrixXd::Zero(u.size(), u.size())};
  Eigen::Index at = 0;
  for (const int size : sizes) {
    Eigen::VectorXd mirrored = -u.segment(at, size);
    mirrored[0] = u[at];
    const double side = u.segment(at + 1, size - 1).norm();
    const double distance = (u[at] - side) * (u[at] + side);
    result.gradient.segment(at, size) = -2 / distance * mirrored;
    auto block = result.hessian.block(at, at, size, size);
    block = 4 / (distance * distance) * mirrored * mirrored.transpose();
    block.diagonal().array() += 2 / distance;
    block(0, 0) -= 4 / distance;
    at += size;
  }
  return result;
}

/// Minimises weight * objective + barrier from x; returns the number of Newton steps.
int centre(const ConeProgram& p, double weight, Eigen::VectorXd& x) {
  const auto value = [&](const Eigen::VectorXd& y) {
    return weight * (0.5 * y.dot(p.P * y) + p.q.dot(y)) + barrier_value(p.F * y + p.g, p.sizes);
  };
  for (int step = 0; step < kCentringSteps; ++step) {
    const Barrier b = barrier(p.F * x + p.g, p.sizes);
    const Eigen::VectorXd gradient = weight * (p.P * x + p.q) + p.F.transpose() * b.gradient;
    const Eigen::MatrixXd hessian = weight * p.P + p.F.transpose() * b.hessian * p.F;
    const Eigen::VectorXd direction = -hessian.ldlt().solve(gradient);
    const double decrease = -gradient.dot(direction);
    if (!(0.5 * decrease > kCentred)) return step;
    const double before = value(x);
    double length = 1;
    while (length > kShortest &&
           !(value(x + length * direction) <= before - kSufficient * length * decrease)) {
      length *= 0.5;
    }
    if (length <= kShortest) return step;  // as good as the arithmetic allows
    x += length * direction;
  }
  return kCentringSteps;
}

}  // namespace

double min_slack(const Eigen::VectorXd& u, const std::vector<int>& sizes) {
  double least = std::numeric_limits<double>::infinity();
  Eigen::Index at = 0;
  for (const int size : sizes) {
    least = std::min(least, u[at] - u.segment(at + 1, size - 1).norm());
    at += size;
  }
  return least;
}

ConeSolution solve(const ConeProgram& program, const Eigen::VectorXd& start, double accuracy) {
  const double parameter = 2.0 * static_cast<double>(program.sizes.size());
  ConeSolution solution{.x = start};
  double weight = 1;
  do {
    solution.steps += centre(program, weight, solution.x);
    solution.gap = parameter / weight;
    weight *= kGrowth;
  } while (solution.gap > accuracy);
  return solution;
}

}  // namespace palpate::numerics
