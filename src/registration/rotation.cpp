// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/rotation.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "palpate/core/error.hpp"
#include "registration/certificate.hpp"
#include "registration/dual_sdp.hpp"
#include "registration/nearest_rotation.hpp"

namespace palpate::registration {
namespace {

struct Expansion {
  Eigen::Vector3d gradient;
  Eigen::Matrix3d hessian;
};

/// Second-order expansion of f(R exp(w)) at w = 0.
Expansion expand(const Matrix10d& Q, const Eigen::Matrix3d& R) {
  const Vector10d q = Q * homogeneous(R);
  Eigen::Matrix<double, 9, 3> J;  // of vec(R exp(w)): columns R (w x e_c)
  for (int c = 0; c < 3; ++c) {
    J.block<3, 3>(3 * c, 0) = -R * skew(Eigen::Vector3d::Unit(c));
  }
  const Eigen::Matrix3d A = R.transpose() * Eigen::Map<const Eigen::Matrix3d>(q.data());
  Expansion result;
  result.gradient = 2 * J.transpose() * q.head<9>();
  result.hessian = 2 * J.transpose() * (Q.topLeftCorner<9, 9>() * J) + A + A.transpose();
  result.hessian.diagonal().array() -= 2 * A.trace();
  return result;
}

/// Newton step with the Hessian's eigenvalues made positive; at most 0.7 rad.
Eigen::Vector3d descent(const Expansion& expansion) {
  constexpr double kLongest = 0.7, kFlat = 1e-10;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(expansion.hessian);
  const Eigen::Vector3d curvature = eigen.eigenvalues().cwiseAbs();
  const double floor = std::max(kFlat * curvature.maxCoeff(), 1e-300);
  const Eigen::Vector3d step = -(eigen.eigenvectors().transpose() * expansion.gradient)
                                    .cwiseQuotient(curvature.cwiseMax(floor));
  const double length = step.norm();
  return eigen.eigenvectors() * (length > kLongest ? step * (kLongest / length) : step);
}

double cost_of(const Matrix10d& Q, const Eigen::Matrix3d& R) {
  const Vector10d r = homogeneous(R);
  return r.dot(Q * r);
}

/// Projected ridge least squares: the relaxed problem without constraints, kept bounded.
Eigen::Matrix3d first_candidate(const Matrix10d& Q, double ridge) {
  Matrix9d A = Q.topLeftCorner<9, 9>();
  A.diagonal().array() += ridge * std::max(A.trace(), 1e-300);
  const Eigen::Matrix<double, 9, 1> x = A.llt().solve(-Q.topRightCorner<9, 1>());
  return nearest_rotation(Eigen::Map<const Eigen::Matrix3d>(x.data()));
}

/// The 24 rotations that keep a cube: signed permutations of determinant 1.
std::vector<Eigen::Matrix3d> cube_rotations() {
  std::vector<Eigen::Matrix3d> rotations;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      if (a == b) continue;
      for (int signs = 0; signs < 4; ++signs) {
        Eigen::Matrix3d R;
        R.col(0) = (signs & 1 ? -1 : 1) * Eigen::Vector3d::Unit(a);
        R.col(1) = (signs & 2 ? -1 : 1) * Eigen::Vector3d::Unit(b);
        R.col(2) = R.col(0).cross(R.col(1));
        rotations.push_back(R);
      }
    }
  }
  return rotations;
}

/// Local searches from several rotations, the best of which is kept.
class Search {
 public:
  Search(const Matrix10d& objective, const RotationOptions& options)
      : objective_(objective), options_(options) {}

  /// @return whether the new minimum is clearly lower than the best so far
  bool start(const Eigen::Matrix3d& R) {
    int steps = 0;
    const Eigen::Matrix3d minimum = refine_rotation(objective_, R, options_, &steps);
    const double cost = cost_of(objective_, minimum);
    estimate_.local_steps += steps;
    const bool first = estimate_.starts++ == 0;
    const bool better = first || cost < cost_ - 1e-9 * std::abs(objective_.trace());
    if (better) {
      cost_ = cost;
      estimate_.R = minimum;
    }
    return better;
  }

  /// Certifies the best; where that fails, keeps the direction of escape.
  bool certify() {
    const DetailedCertificate detailed = certify_in_detail(objective_, estimate_.R, options_);
    estimate_.certificate = detailed.certificate;
    escape_ = detailed.escape;
    return detailed.certificate.certified;
  }

  /// Starts from the dual's own solution and takes over its bound, if that is the better one.
  void follow_dual() {
    const DualSolution dual = solve_dual(objective_);
    if (start(dual.R)) certify();
    RotationCertificate& certificate = estimate_.certificate;
    certificate.bound = std::min(certificate.bound, std::max(0.0, certificate.cost - dual.value));
    const double reference = std::max(certificate.cost, objective_.trace() / 10);
    certificate.certified = certificate.bound <= options_.relative_gap * reference;
  }

  /// Starts along the direction in which the relaxed problem descends.
  bool follow_escape() {
    bool better = false;
    const Eigen::Matrix3d center = estimate_.R, D = Eigen::Map<Eigen::Matrix3d>(escape_.data());
    for (const double length : {2.0, -2.0, 0.7, -0.7}) {
      better |=
          start(center * nearest_rotation(Eigen::Matrix3d::Identity() * (1 + length * escape_[9]) +
                                          length * D));
    }
    return better;
  }

  const RotationEstimate& estimate() const { return estimate_; }

 private:
  const Matrix10d& objective_;
  const RotationOptions& options_;
  RotationEstimate estimate_;
  double cost_ = 0;
  Vector10d escape_ = Vector10d::Zero();
};

}  // namespace

Eigen::Matrix3d refine_rotation(const Matrix10d& objective, const Eigen::Matrix3d& R,
                                const RotationOptions& options, int* steps) {
  const double scale = objective.trace();
  Eigen::Matrix3d best = R;
  double cost = cost_of(objective, best);
  int count = 0;
  while (count < options.max_local_steps) {
    const Expansion expansion = expand(objective, best);
    if (!(expansion.gradient.norm() > 1e-13 * scale)) break;
    Eigen::Vector3d step = descent(expansion);
    ++count;
    double next_cost = cost;
    Eigen::Matrix3d next = best;
    int halvings = 0;
    for (; halvings < 10; ++halvings, step *= 0.4) {
      next = best * exp_so3(step);
      next_cost = cost_of(objective, next);
      if (next_cost <= cost + 1e-16 * scale) break;
    }
    if (halvings == 10) break;
    best = next;
    cost = next_cost;
    if (step.norm() < 1e-9) break;  // Newton converges quadratically: nothing is left to gain
  }
  if (steps != nullptr) *steps = count;
  return best;
}

RotationEstimate solve_rotation(const Matrix10d& objective, const RotationOptions& options) {
  if (!objective.allFinite()) throw BadInput("the objective holds a value that is not finite");
  Search search(objective, options);
  search.start(first_candidate(objective, 1e-6));
  if (search.certify()) return search.estimate();
  if (search.follow_escape() && search.certify()) return search.estimate();
  static const std::vector<Eigen::Matrix3d> cube = cube_rotations();
  bool better = false;
  for (const Eigen::Matrix3d& R : cube) better |= search.start(R);
  if (better && search.certify()) return search.estimate();
  search.follow_dual();
  return search.estimate();
}

}  // namespace palpate::registration
