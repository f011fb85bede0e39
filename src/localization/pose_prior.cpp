// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/pose_prior.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "localization/search/pose_family.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"

namespace palpate::localization {
namespace {

using std::numbers::pi;

constexpr double kSpacing = 5 * kDegree;  // of components along a free axis, at most
constexpr double kMinRotation = 0.5 * kDegree;
constexpr double kMinTranslation = 0.0005;  // m
constexpr double kRounding = 1e-12;
constexpr double kBallRotation = 0.05, kBallTranslation = 0.005;  // of the residual set, rad, m
constexpr double kDistrust = 0.05;  // that the earlier posterior is wrong, however sure it is

void check_motion(const Matrix6d& covariance) {
  if (!covariance.allFinite()) {
    throw BadInput("motion_covariance holds a value that is not finite");
  }
  const double skewness = (covariance - covariance.transpose()).cwiseAbs().maxCoeff();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> spectrum(covariance, Eigen::EigenvaluesOnly);
  const double least = spectrum.eigenvalues()[0];
  if (skewness > kRounding || least < -kRounding) {
    throw BadInput(fmt::format("motion_covariance is off symmetry by {}, its least eigenvalue {}",
                               skewness, least));
  }
}

Matrix6d isotropic(double rotation, double translation) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(rotation * rotation),
      Eigen::Vector3d::Constant(translation * translation);
  return variances.asDiagonal();
}

Matrix6d turned(const Matrix6d& covariance, const Eigen::Matrix3d& turn) {
  Matrix6d both = Matrix6d::Zero();
  both.topLeftCorner<3, 3>() = turn;
  both.bottomRightCorner<3, 3>() = turn;
  return both * covariance * both.transpose();
}

/// One component, or those along the free axis, before the motion.
std::vector<PosePrior::Component> components_of(const Mode& mode) {
  if (!mode.free_axis) return {{mode.T_frame_object, mode.weight, mode.covariance}};
  const FreeAxis& axis = *mode.free_axis;
  const int count = std::max(1, static_cast<int>(std::ceil(2 * axis.extent / kSpacing - 1e-6)));
  const double step = 2 * axis.extent / count;
  const PoseFamily family(PosePoint(mode.T_frame_object), axis);
  const Matrix6d covariance = covariance_along(mode, step / 2);  // neighbours join evenly
  std::vector<PosePrior::Component> result;
  for (int k = 0; k < count; ++k) {
    const double angle = -axis.extent + (k + 0.5) * step;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, axis.direction).toRotationMatrix();
    result.push_back({family.at(angle).isometry(), mode.weight / count, turned(covariance, turn)});
  }
  return result;
}

void sort_heaviest_first(PosePrior& prior) {
  std::stable_sort(prior.components.begin(), prior.components.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
}

}  // namespace

PosePrior prior_from(const Posterior& posterior, const Matrix6d& motion_covariance) {
  PosePrior prior = prior_from_modes(posterior, motion_covariance);
  const double modes = 1 - posterior.residual_mass();
  double known = modes;
  if (const std::size_t count = posterior.residual_set.size(); count > 0) {
    known = std::clamp(posterior.credible_mass, modes, 1.0);
    const Matrix6d covariance = isotropic(kBallRotation, kBallTranslation) + motion_covariance;
    for (const auto& pose : posterior.residual_set) {
      prior.components.push_back({pose, (known - modes) / static_cast<double>(count), covariance});
    }
    sort_heaviest_first(prior);
  }
  spread_elsewhere(std::max(kDistrust, 1 - known), prior);
  return prior;
}

PosePrior prior_from_modes(const Posterior& posterior, const Matrix6d& motion_covariance) {
  if (posterior.modes.empty()) throw BadInput("a prior from a posterior of 0 modes");
  check_motion(motion_covariance);
  PosePrior prior;
  for (const Mode& mode : posterior.modes) {
    for (PosePrior::Component& component : components_of(mode)) {
      component.covariance += motion_covariance + isotropic(kMinRotation, kMinTranslation);
      component.covariance =
          (0.5 * (component.covariance + component.covariance.transpose())).eval();
      prior.components.push_back(component);
    }
  }
  sort_heaviest_first(prior);
  return prior;
}

void append(const PosePrior& part, double share, PosePrior& prior) {
  for (auto component : part.components) {
    component.weight *= share;
    prior.components.push_back(component);
  }
  sort_heaviest_first(prior);
}

void spread_elsewhere(double elsewhere, PosePrior& prior) {
  constexpr double kPoses = 8 * pi * pi * 1e-3;  // of all rotations and 1 dm^3, rad^3 m^3
  double peak = 0;
  for (const auto& component : prior.components) {
    const double volume = std::sqrt(std::pow(2 * pi, 6) * component.covariance.determinant());
    peak = std::max(peak, component.weight / volume);
  }
  prior.floor = std::min(0.5, elsewhere / kPoses / peak);
}

}  // namespace palpate::localization
