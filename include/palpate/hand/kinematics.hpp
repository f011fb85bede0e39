// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/hand/joints.hpp"

namespace palpate::hand {

/// A ball in a link's frame; together they stand for the hand's surface.
struct LinkSphere {
  int link = 0;
  Eigen::Vector3d center;
  double radius = 0;
};

/// A rigid link and the hinge that joins it to its parent.
struct Link {
  std::string name;
  int parent = -1;                                                  ///< -1: the base
  Eigen::Isometry3d T_parent_link = Eigen::Isometry3d::Identity();  ///< at joint angle 0
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< of the joint, in the link's frame
  int joint = -1;                                  ///< index into JointVector; -1: fixed
};

/// The hand as data: links (parents first) from the base, tips and surface. Serializable, so that a
/// recording can be read back without a simulator.
struct HandModel {
  std::vector<Link> links;
  int palm = -1;                       ///< link of the palm
  std::array<int, kFingers> distal{};  ///< link of each fingertip
  /// Fingertip as a capsule along the distal link's z axis, from a to b, m.
  struct TipCapsule {
    Eigen::Vector3d a, b;
    double radius = 0;
  };
  std::array<TipCapsule, kFingers> tips;
  std::vector<LinkSphere> spheres;
  /// By how much each link that may_be_misplaced() is believed to be, root mean square, m.
  double kinematic_error = 0;
};

/// T_base_link of every link at the given joint angles.
std::vector<Eigen::Isometry3d> forward_kinematics(const HandModel& hand, const JointVector& joints);

/// Geometric Jacobian [w; v] (6 x kJoints) of a point fixed to a link, in the base's axes.
/// @param p_link  the point in the link's frame, m
Eigen::Matrix<double, 6, kJoints> jacobian(const HandModel& hand, const JointVector& joints,
                                           int link, const Eigen::Vector3d& p_link);

/// True of the links whose place in a real hand differs from the model: those that a joint moves,
/// but only one of the two that share their place in a universal joint.
bool may_be_misplaced(const Link& link);

/// Those of the links from this one to the base that may be: indices into HandModel::links.
std::vector<int> misplaced_links(const HandModel& hand, int link);

/// The same hand with every such link displaced from where the model says, by a normal vector of
/// root mean square length `rms` (m), which becomes its kinematic_error: how far a real hand is
/// from its drawing.
HandModel with_perturbed_links(HandModel hand, double rms, RandomStream& random);

}  // namespace palpate::hand
