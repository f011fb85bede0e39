// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/free_motions.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <cmath>

namespace palpate::registration {
namespace {

/// A unit twist, its rotation times the arm, about the centre.
FreeMotion named(const Vector6d& scaled, const CentredInformation& about, double arm) {
  constexpr double kMostlyShift = 0.2, kNoPitch = 0.1;  // shares of the unit twist; of the arm
  FreeMotion motion;
  motion.point = about.center;
  const Eigen::Vector3d turn = scaled.head<3>(), shift = scaled.tail<3>();
  if (turn.norm() < kMostlyShift) {
    motion.direction = shift.normalized();
    return motion;
  }
  const Eigen::Vector3d w = turn / arm;
  motion.direction = w.normalized();
  motion.point += w.cross(shift) / w.squaredNorm();
  motion.pitch = w.dot(shift) / w.squaredNorm();
  const bool screw = std::abs(motion.pitch) > kNoPitch * arm;
  motion.kind = screw ? FreeMotion::Kind::kScrew : FreeMotion::Kind::kRotation;
  if (!screw) motion.pitch = 0;
  return motion;
}

}  // namespace

std::string_view to_string(FreeMotion::Kind kind) {
  switch (kind) {
    case FreeMotion::Kind::kRotation:
      return "rotation";
    case FreeMotion::Kind::kTranslation:
      return "translation";
    case FreeMotion::Kind::kScaling:
      return "scaling";
    case FreeMotion::Kind::kScrew:
      break;
  }
  return "screw";
}

void exclude_turns(CentredInformation& about, const Eigen::Matrix3d& excluded) {
  about.information.topLeftCorner<3, 3>() += about.weight_sum * about.squared_arm * excluded;
}

std::vector<FreeMotion> free_motions(const CentredInformation& about, double tolerance) {
  // A point's arm is none: its scale only has to be a number.
  const double arm = about.squared_arm > 0 ? std::sqrt(about.squared_arm) : 1;
  Vector6d scale = Vector6d::Ones();
  scale.head<3>().setConstant(about.squared_arm > 0 ? 1 / arm : 0);
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(scale.asDiagonal() * about.information *
                                                      scale.asDiagonal());
  const auto free = (eigen.eigenvalues().array() <= tolerance * about.weight_sum).count();
  if (free == 0) return {};
  // Of the free twists the combinations that turn least come first: shifts, if there are any.
  const Eigen::MatrixXd basis = eigen.eigenvectors().leftCols(free);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(basis.topRows<3>(), Eigen::ComputeFullV);
  const Eigen::MatrixXd combined = basis * svd.matrixV();
  std::vector<FreeMotion> motions;
  for (Eigen::Index k = free; k-- > 0;) motions.push_back(named(combined.col(k), about, arm));
  return motions;
}

}  // namespace palpate::registration
