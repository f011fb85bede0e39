// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/quadratic_form.hpp"

namespace palpate::registration {

struct RotationOptions {
  /// A rotation is certified if its bound is at most this share of max(f, tr(Q~)/10).
  double relative_gap = 1e-6;
  int max_local_steps = 60;         ///< Newton steps from one start
  int max_certificate_steps = 100;  ///< Newton steps of the search for multipliers
};

/// What is proven of a rotation.
struct RotationCertificate {
  bool certified = false;
  double cost = 0;   ///< f(R) = r~' Q~ r~, m^2
  double bound = 0;  ///< f(R) - f* is at most this, m^2
  int steps = 0;     ///< Newton steps beyond the closed-form multipliers
};

/// Bounds how far a rotation is from the global minimum of r~' Q~ r~ over SO(3).
///
/// Multipliers of the 22 constraints of thesis problem P (21 independent) that make R stationary
/// come in closed form up to 14 free ones; these are the least in norm, or, if the penalised matrix
/// Z is not positive semidefinite with them, found by a barrier method. With Z complete and
/// |r~|^2 = 4: f(R) - f* <= r~' Z r~ - 4 min(0, lambda_min(Z)), for any multipliers and any R.
/// @param objective  Q~, symmetric 10x10 (thesis eq. 6.25), m^2
/// @throws BadInput if the objective holds a value that is not finite or R is no rotation to 1e-6
RotationCertificate certify_rotation(const Matrix10d& objective, const Eigen::Matrix3d& R,
                                     const RotationOptions& options = {});

/// Local minimum of r~' Q~ r~ over SO(3) near R, by Newton's method with a line search.
/// @param steps  if given, receives the number of steps
Eigen::Matrix3d refine_rotation(const Matrix10d& objective, const Eigen::Matrix3d& R,
                                const RotationOptions& options = {}, int* steps = nullptr);

struct RotationEstimate {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  RotationCertificate certificate;
  int local_steps = 0;  ///< Newton steps on SO(3), all starts together
  int starts = 0;       ///< local searches
};

/// Rotation that minimises r~' Q~ r~ over SO(3), with a certificate of global optimality.
///
/// Briales & Gonzalez-Jimenez, CVPR 2017 (thesis eqs 6.24-6.34), solved from the other end: a local
/// minimum first, then the dual variables that prove it. Where they do not exist, the dual's
/// direction of descent, the 24 rotations of a cube and at last the solution of solve_dual() start
/// further searches.
/// @throws BadInput if the objective holds a value that is not finite
RotationEstimate solve_rotation(const Matrix10d& objective, const RotationOptions& options = {});

}  // namespace palpate::registration
