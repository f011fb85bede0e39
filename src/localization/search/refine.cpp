// SPDX-License-Identifier: Apache-2.0
#include "localization/search/refine.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace palpate::localization {
namespace {

constexpr double kScaleStep = 0.6;
constexpr int kStepsPerScale = 2, kLastSteps = 4;
constexpr int kTries = 3;  // of shorter steps
constexpr double kFirstDamping = 1e-3, kMinDamping = 1e-4, kMoreDamping = 20, kLessDamping = 0.3;
constexpr double kLongestRefineTurn = 0.3, kLongestRefineStep = 0.02;  // rad, m
constexpr double kConverged = 0.01;  // fall of the energy below which a scale is done with
/// Weak prior that keeps the information regular: 1 rad and 50 mm.
constexpr double kWeakestRotation = 1.0, kWeakestTranslation = 400.0;

Matrix6d weak_prior() {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(kWeakestRotation),
      Eigen::Vector3d::Constant(kWeakestTranslation);
  return diagonal.asDiagonal();
}

SearchPose stepped(const SearchPose& from, const Vector6d& step) {
  Eigen::Vector3d w = step.head<3>(), v = step.tail<3>();
  if (w.norm() > kLongestRefineTurn) w *= kLongestRefineTurn / w.norm();
  if (v.norm() > kLongestRefineStep) v *= kLongestRefineStep / v.norm();
  return {turn_by(w.cast<float>()) * from.R, from.t + v.cast<float>()};
}

/// One damped step; returns by how much the energy fell, 0 if no step lowers it.
float descend(SearchPose& pose, float& now, double& damping, const Energy& energy) {
  const NormalEquations equations = energy.linearized(pose);
  const Matrix6d regular = equations.H + 0.01 * weak_prior();
  for (int attempt = 0; attempt < kTries; ++attempt) {
    Matrix6d damped = regular;
    damped.diagonal() += damping * regular.diagonal();
    const SearchPose to = stepped(pose, -damped.ldlt().solve(equations.g));
    const float there = energy(to, now);
    if (there < now) {
      const float fall = now - there;
      pose = to;
      now = there;
      damping = std::max(kMinDamping, kLessDamping * damping);
      return fall;
    }
    damping *= kMoreDamping;
  }
  return 0;
}

}  // namespace

EnergyLadder energy_ladder(const std::function<Energy(double)>& energy_at, double first_scale) {
  EnergyLadder ladder;
  for (double scale = first_scale; scale > 1.1; scale *= kScaleStep) {
    ladder.emplace_back(scale, energy_at(scale));
  }
  ladder.emplace_back(1.0, energy_at(1.0));
  return ladder;
}

RefinedPose refined(const SearchPose& start, const EnergyLadder& ladder) {
  RefinedPose result;
  result.pose = start;
  double damping = kFirstDamping;
  for (const auto& [scale, energy] : ladder) {
    result.energy = energy(result.pose);
    const int steps = scale > 1 ? kStepsPerScale : kLastSteps;
    for (int i = 0; i < steps; ++i) {
      const float fall = descend(result.pose, result.energy, damping, energy);
      if (static_cast<double>(fall) < kConverged) break;
    }
    damping = std::min(damping, 1.0);
  }
  result.pose.R = Eigen::Quaternionf(result.pose.R).normalized().toRotationMatrix();
  result.information = ladder.back().second.linearized(result.pose).H + weak_prior();
  const Eigen::LLT<Matrix6d> root(result.information);
  const double log_det = 2 * Matrix6d(root.matrixL()).diagonal().array().log().sum();
  result.log_weight = -static_cast<double>(result.energy) - 0.5 * log_det;
  return result;
}

Matrix6d covariance_of(const RefinedPose& refined) { return refined.information.inverse(); }

int open_directions(const RefinedPose& refined) {
  const Vector6d root = weak_prior().diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6d relative = root.asDiagonal() * refined.information * root.asDiagonal();
  const Vector6d gains =
      Eigen::SelfAdjointEigenSolver<Matrix6d>(relative, Eigen::EigenvaluesOnly).eigenvalues();
  return static_cast<int>((gains.array() < 2).count());
}

}  // namespace palpate::localization
