// SPDX-License-Identifier: Apache-2.0
#include "skills/load_calibration.hpp"

namespace palpate::skills {
namespace {

constexpr double kDamping = 1e-3;  // of the normal equations, against attitudes that are alike

}  // namespace

void LoadCalibration::add(const hand::MountPosition& mount, const Eigen::Vector3d& load) {
  Eigen::Matrix<double, 3, 4> A;
  A << mount.pose().linear(), Eigen::Vector3d::UnitZ();
  information_ += A.transpose() * A;
  weighted_ += A.transpose() * load;
}

LoadError LoadCalibration::error() const {
  const Eigen::Matrix4d damped = information_ + kDamping * Eigen::Matrix4d::Identity();
  const Eigen::Vector4d found = damped.ldlt().solve(weighted_);
  return {found.head<3>(), found[3]};
}

}  // namespace palpate::skills
