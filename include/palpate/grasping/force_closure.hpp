// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/core/options.hpp"
#include "palpate/grasping/grasp_matrix.hpp"

namespace palpate::grasping {

struct ForceClosure {
  bool closed = false;
  /// Of the internal contact forces whose normal parts sum to 1 N: the most by which all of them
  /// can be within their cones, N. Above 0 with force closure; -infinity without internal forces.
  double margin = 0;
  int rank = 0;  ///< of the transmitted wrenches, 6 if they span all of them
};

/// Whether the contacts can balance any wrench on the object, with their true (round) cones.
///
/// They can if their wrenches have rank 6 and there are internal forces, G w_c = 0, strictly within
/// all cones (Murray, Li & Sastry, A Mathematical Introduction to Robotic Manipulation, 1994,
/// proposition 5.2 and its converse). The latter is a cone program, solved to 1e-9.
/// @throws BadInput for a contact frame that is not finite (all of these)
ForceClosure force_closure(const GraspContacts& contacts);

struct QualityOptions {
  int edges = 8;         ///< of the pyramid inside each friction cone
  double length = 0.05;  ///< m, by which moments are divided to compare them with forces

  template <class Visitor>
  void visit(Visitor&& v) {
    v("edges", edges, 3, 64, "of the pyramid inside each friction cone");
    v("length", length, 1e-4, 10.0, "m, by which moments are divided");
  }
};

/// Grasp quality: radius (N) of the largest ball about 0 in the convex hull of the wrenches that
/// contacts make whose normal forces sum to 1 N (Ferrari & Canny, ICRA 1992). 0 without force
/// closure. A pyramid lies within its cone, so this is never more than the exact value.
/// @param p_mount_object  where moments are taken, m
/// @throws BadInput for options out of range or a point that is not finite
double grasp_quality(const GraspContacts& contacts, const Eigen::Vector3d& p_mount_object,
                     const QualityOptions& options = {});

struct BalanceOptions {
  double max_normal_force = 50;  ///< N, of each contact

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_normal_force", max_normal_force, 1e-3, 1e5, "N, of each contact");
  }
};

enum class BalanceStatus {
  balanced,
  impossible  ///< no forces within cones and limit make the wrench
};

struct Balance {
  BalanceStatus status = BalanceStatus::impossible;
  Eigen::VectorXd contact_wrenches;  ///< w_c (6 n) in their frames; empty if impossible
  /// N, by which all forces are within cones and limit at the best; negative: by which they miss.
  double slack = 0;
  int steps = 0;  ///< of the solver
};

/// The smallest contact forces, within their friction cones, that make a wrench on the object:
/// minimises the sum of f_n^2 + f_t^2 + f_o^2 + (m_n / e_n)^2 such that G w_c = wrench.
/// @param wrench  [m; f] that the hand is to exert at p_mount_object, N m and N, mount axes
/// @throws BadInput for a wrench or point that is not finite, or options out of range
Balance balance_wrench(const GraspContacts& contacts, const Eigen::Vector3d& p_mount_object,
                       const Vector6d& wrench, const BalanceOptions& options = {});

}  // namespace palpate::grasping
