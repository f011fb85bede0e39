// SPDX-License-Identifier: Apache-2.0
#include "grasping/wrench_space.hpp"

#include <Eigen/SVD>

namespace palpate::grasping {
namespace {

constexpr double kRankTolerance = 1e-9;  // of the largest singular value

}  // namespace

WrenchSpace wrench_space(const GraspContacts& contacts, const Eigen::Vector3d& p_mount_object,
                         double length) {
  const Eigen::MatrixXd H = transmission(contacts);
  WrenchSpace space;
  space.wrenches = grasp_matrix(contacts, p_mount_object) * H.transpose();
  space.wrenches.topRows<3>() /= length;
  space.axis = Eigen::VectorXd::Zero(H.rows());
  space.normal_per_axis = Eigen::VectorXd::Zero(H.rows());
  space.scale = Eigen::VectorXd::Ones(H.rows());
  Eigen::Index at = 0;
  for (const GraspContact& contact : contacts) {
    const Eigen::VectorXd scale = cone_scale(contact.model, contact.friction);
    space.scale.segment(at, scale.size()) = scale;
    space.axis[at] = 1;
    space.normal_per_axis[at] = 1 / scale[0];
    space.sizes.push_back(static_cast<int>(scale.size()));
    at += scale.size();
  }
  space.wrenches = space.wrenches * space.scale.cwiseInverse().asDiagonal();
  return space;
}

AffineSpace solve_affine(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  svd.setThreshold(kRankTolerance);
  AffineSpace result;
  result.rank = static_cast<int>(svd.rank());
  result.particular = svd.solve(b);
  result.residual = (A * result.particular - b).norm();
  result.directions = svd.matrixV().rightCols(A.cols() - svd.rank());
  return result;
}

}  // namespace palpate::grasping
