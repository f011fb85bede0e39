// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "palpate/hand/description.hpp"

namespace palpate::simulation {

/// What a user says of a hand in a TOML file of his own; what is empty is found out.
struct HandNotes {
  std::string model;    ///< MJCF or URDF file; relative to the TOML file
  std::string root;     ///< the hand's first body; its own joints are left out
  std::string palm;     ///< body that the fingers are attached to
  std::string tips;     ///< bodies of the fingertips, separated by commas, one a finger
  std::string fingers;  ///< their names, in the same order
  std::string thumb;    ///< name of the finger that closes against the others
  std::string tip_shape = "capsule";  ///< or "hull": of boxes and meshes, not a capsule fitted
  std::string closing;  ///< joints that close the fingers; "-joint" closes towards its lower limit
  double max_torque = 0;   ///< N m, of every joint; 0: the file's, where plausible
  bool has_mount = false;  ///< implied by a pose below that is not zero
  Eigen::Vector3d mount_xyz = Eigen::Vector3d::Zero();  ///< of the root in the mount's frame, m
  Eigen::Vector3d mount_rpy = Eigen::Vector3d::Zero();  ///< roll, pitch and yaw of it, deg

  template <class Visitor>
  void visit(Visitor& v) {
    v("model", model, "MJCF or URDF file, relative to this one");
    v("root", root, "first body of the hand");
    v("palm", palm, "body that the fingers are attached to");
    v("tips", tips, "bodies of the fingertips, separated by commas");
    v("fingers", fingers, "names of the fingers, in the order of the fingertips");
    v("thumb", thumb, "finger that closes against the others");
    v("tip_shape", tip_shape, "capsule (fitted), or hull (convex hull of boxes and meshes)");
    v("closing", closing, "joints that close the fingers; -JOINT closes towards its lower limit");
    v("max_torque", max_torque, 0, 100,
      "N m, torque limit of every joint; 0: the limits in the model");
    v("mount.given", has_mount, "use the pose below even if it is zero; else it is derived");
    v("mount.x", mount_xyz.x(), -2, 2, "m, x of the root in the mount's frame");
    v("mount.y", mount_xyz.y(), -2, 2, "m, y of the root in the mount's frame");
    v("mount.z", mount_xyz.z(), -2, 2, "m, z of the root in the mount's frame");
    v("mount.roll", mount_rpy.x(), -360, 360, "deg, roll of the root in the mount's frame");
    v("mount.pitch", mount_rpy.y(), -360, 360, "deg, pitch of the root in the mount's frame");
    v("mount.yaw", mount_rpy.z(), -360, 360, "deg, yaw of the root in the mount's frame");
  }
};

/// Something wrong with a hand's file, and what can be done about it.
struct HandProblem {
  std::string what, hint;
};

/// A hand as its model file has it: links, joints, drives, fingertips and mount. Postures are
/// grasping::derive_postures()'.
struct DescribedHand {
  hand::Description hand;
  std::vector<std::string> guesses;   ///< what the file does not say, in words
  std::vector<HandProblem> problems;  ///< that do not keep it from being used
  std::string failure;                ///< why no postures were found for it; else empty
};

/// Commands at which the joints that close fingers have gone a share of their way to closed, and
/// all others are straight.
hand::ActuatorVector partly_closed(const hand::Description& hand, double share);

/// Reads a hand from an MJCF or URDF file.
///
/// Fingers are the chains of hinges below the palm, fingertips the last body of each that can
/// collide. Its surface is its capsule or sphere, else the convex hull of what collides. Hinges
/// that an equality or a mimic ties to another one follow it. Every other hinge gets a position
/// servo; where the file has none, by a rule: 300 N/m at the fingertip, critically damped. Torque
/// limits that press with more than 60 N are lowered to 18 N.
/// @throws BadInput for a file that cannot be used, with what to do about it
DescribedHand describe_hand(const std::filesystem::path& file, const HandNotes& notes = {});

}  // namespace palpate::simulation
