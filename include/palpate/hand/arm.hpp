// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "palpate/hand/description.hpp"
#include "palpate/hand/hand.hpp"

namespace palpate::hand {

inline constexpr int kMaxArmJoints = 8;

/// One value a joint of an arm, from its stand on (rad). At most kMaxArmJoints; no heap.
using ArmVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxArmJoints, 1>;

/// Geometric Jacobian [w; v] of the mount in the world's axes, one column a joint.
using ArmJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxArmJoints>;

struct ArmJoint {
  std::string name;
  Range range;
  double max_speed = 2;          ///< rad/s
  double max_acceleration = 15;  ///< rad/s^2
};

/// Where a simulator finds the arm.
struct ArmFile {
  std::filesystem::path path;          ///< MJCF
  std::string root, flange;            ///< bodies
  std::vector<std::string> actuators;  ///< one a joint
};

/// An arm as plain data: a chain of hinges that stands in the world and carries a hand's mount.
struct ArmDescription {
  std::string name;
  std::vector<Link> links;  ///< parents first, from the stand
  std::vector<ArmJoint> joints;
  std::vector<LinkSphere> spheres;  ///< for the surface of its links
  int flange = -1;                  ///< link
  Eigen::Isometry3d T_world_stand = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_flange_mount = Eigen::Isometry3d::Identity();  ///< of the hand's mount
  /// What the hand has before its first joint, in the mount's frame.
  std::vector<LinkSphere> carried = {};
  /// A hand of 4 kg then loads its mount by its own inertia by some 15 N.
  MountLimits limits = {.acceleration = 3, .turn_acceleration = 10, .guarded_speed = 0.02};
  ArmFile file = {};

  [[nodiscard]] Eigen::Index joint_count() const { return std::ssize(joints); }
};

/// T_world_link of every link. @param joints  rad
std::vector<Eigen::Isometry3d> link_poses(const ArmDescription& arm, const ArmVector& joints);

/// T_world_mount of the hand that the arm carries. @param joints  rad
Eigen::Isometry3d mount_pose(const ArmDescription& arm, const ArmVector& joints);

ArmJacobian mount_jacobian(const ArmDescription& arm, const ArmVector& joints);

/// Joint angles within their ranges that bring the mount to a pose, to 10 um and 10 urad: those
/// which damped least squares (Levenberg-Marquardt; Wampler 1986) finds from `near`.
/// @return nothing where there are none or the search ends at a limit
std::optional<ArmVector> inverse_kinematics(const ArmDescription& arm,
                                            const Eigen::Isometry3d& T_world_mount,
                                            const ArmVector& near);

/// Different solutions of the inverse kinematics, found from a fixed set of starts; those of a
/// redundant arm are examples.
std::vector<ArmVector> inverse_kinematics_branches(const ArmDescription& arm,
                                                   const Eigen::Isometry3d& T_world_mount);

/// What the arm overlaps, in words: the table (z = 0) or itself, with the hand's first link; empty
/// if nothing. Links that are neighbours do not count, nor does what stands on the table.
std::string arm_collision(const ArmDescription& arm, const ArmVector& joints);

}  // namespace palpate::hand
