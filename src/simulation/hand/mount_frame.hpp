// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "palpate/simulation/hand/describe_hand.hpp"

namespace palpate::simulation {

/// Whether the user says where the hand is mounted.
bool has_mount(const HandNotes& notes);

/// T_mount_root as the user has it.
Eigen::Isometry3d given_mount(const HandNotes& notes);

/// How far a mount that the user gives is from the one derived, in words; empty if less than 45 deg
/// and 0.1 m.
std::string far_from(const Eigen::Isometry3d& given, const Eigen::Isometry3d& derived);

/// Fingertips in the root's frame while the hand closes, m.
struct ClosingTips {
  std::vector<Eigen::Vector3d> open, half, closed;
};

struct MountFrame {
  Eigen::Isometry3d T_root_mount = Eigen::Isometry3d::Identity();
  bool points_down = false;  ///< the fingers, as a gripper's; else the palm faces down
};

/// Palm down, fingers along +x, its origin between the half closed fingertips. Where all fingers
/// point the same way, reach as far and close against one another rather than onto a palm, they
/// point down, and close along x.
/// @param p_palm  origin of the palm in the root's frame, m
MountFrame derive_mount(const ClosingTips& tips, const Eigen::Vector3d& p_palm, int thumb);

}  // namespace palpate::simulation
