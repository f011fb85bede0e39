// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/grasping/grasp_matrix.hpp"

namespace palpate::grasping {

/// What contacts can do to the object, in the coordinates u of their Lorentz cones (cone_scale).
struct WrenchSpace {
  Eigen::MatrixXd wrenches;         ///< 6 x m: object wrench = wrenches u, moments over `length`
  std::vector<int> sizes;           ///< of the cones
  Eigen::VectorXd axis;             ///< 1 at each cone's first coordinate, which it bounds
  Eigen::VectorXd normal_per_axis;  ///< normal force, N, of a unit of that coordinate; 0 elsewhere
  Eigen::VectorXd scale;            ///< u = scale * lambda
};

WrenchSpace wrench_space(const GraspContacts& contacts, const Eigen::Vector3d& p_mount_object,
                         double length);

/// The solutions of A u = b: particular + directions z.
struct AffineSpace {
  Eigen::VectorXd particular;  ///< the least one
  Eigen::MatrixXd directions;  ///< orthonormal basis of the null space of A
  double residual = 0;         ///< |A particular - b|: 0 if there is a solution
  int rank = 0;                ///< of A
};

AffineSpace solve_affine(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

}  // namespace palpate::grasping
