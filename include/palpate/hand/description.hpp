// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace palpate::hand {

inline constexpr int kMaxJoints = 32;
inline constexpr int kMaxFingers = 8;

/// One value a joint, in the order of Description::joints (rad, N m). At most kMaxJoints; no heap.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;
/// One value an actuator, in the order of Description::actuators (rad, N m).
using ActuatorVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;
/// One value a finger, in the order of Description::fingers; those beyond the hand's mean nothing.
template <class Value>
using PerFinger = std::array<Value, kMaxFingers>;

struct Range {
  double low = 0, high = 0;  ///< rad
};

/// A rigid link and the hinge that joins it to its parent.
struct Link {
  std::string name;
  int parent = -1;                                                  ///< -1: the mount
  Eigen::Isometry3d T_parent_link = Eigen::Isometry3d::Identity();  ///< at joint angle 0
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< of the joint, in the link's frame
  int joint = -1;                                  ///< index into JointVector; -1: fixed
};

/// A ball in a link's frame; together they stand for the hand's surface.
struct LinkSphere {
  int link = 0;
  Eigen::Vector3d center;
  double radius = 0;
};

/// A fingertip as a capsule in the frame of its link. `b` is its outer end.
struct TipCapsule {
  Eigen::Vector3d a, b;  ///< ends of the axis, m
  double radius = 0;     ///< m
};

/// A fingertip's surface of any convex shape: all points within `radius` of the convex hull of
/// `core`, in the frame of its link.
struct TipHull {
  std::vector<Eigen::Vector3d> core;  ///< corners, m
  double radius = 0;                  ///< of its rounded edges, m
};

struct Finger {
  std::string name;
  int link = -1;                     ///< of the fingertip
  TipCapsule tip;                    ///< its surface; beside a hull about as long and wide as that
  std::optional<TipHull> hull = {};  ///< its surface, where that is no capsule
};

struct Joint {
  std::string name;
  Range range;
};

/// How J1 follows J2 in fingers where one tendon pulls both (Shadow's J0).
///
/// Thesis section 2.1: "If joint two exceeds a certain angle, it enforces joint one to flex
/// accordingly". On the real hand J1 never exceeds J2, and J2 may bend while J1 is held straight.
/// So a spring straightens J1, and one that is slack up to `follow_angle` draws it after J2.
struct Coupling {
  double follow_angle = 0.35;       ///< rad, J2 - J1 at which J2 starts to draw J1 along
  double draw_stiffness = 0.5;      ///< N m/rad, of J2 - J1 beyond that
  double return_torque = 0.02;      ///< N m, that straightens J1 at 0
  double return_stiffness = 0.005;  ///< N m/rad, of J1
  double distal_damping = 0.05;     ///< N m s/rad, of J1
  double middle_damping = 0.02;     ///< N m s/rad, of J2: in free flexion it moves first
  double middle_end = 1.571;        ///< rad, the end of J2's range
};

/// A joint that an actuator moves.
struct DrivenJoint {
  int joint = 0;
  double gear = 1;    ///< the actuator's position is the sum of gear * angle over its joints
  double share = 1;   ///< where nothing touches the finger: angle = offset + share * position
  double offset = 0;  ///< rad
};

/// A position-controlled actuator: torque = stiffness (command - position) + integral - damping
/// speed, within the limit. The integral (simulation::IntegralAction) is small, so that contacts
/// stay soft.
struct Actuator {
  std::string name;
  std::vector<DrivenJoint> joints;
  std::optional<Coupling> coupling;  ///< of two joints [J2, J1], which then share by it
  int finger = -1;                   ///< that it moves; -1: the palm
  double stiffness = 1;              ///< N m / rad
  Range command;                     ///< rad
  double max_torque = 1;             ///< N m
  double damping = 0;                ///< N m s/rad, of its joints; of a simulated hand
  double armature = 0;               ///< kg m^2, of its joints' rotors; of a simulated hand
  double closing = 0;  ///< speed relative to the others while the hand closes; 0: it stays
  double lever = 0.1;  ///< m that the finger's tip moves a radian, roughly
  Range bend;  ///< rad, where its finger is in grasps; low = high: it is not moved for itself
};

/// Attitude of the mount: pitch and roll, rad.
struct Attitude {
  double pitch = 0, roll = 0;
};

/// How the hand comes to an object and closes.
struct Preshape {
  ActuatorVector open;              ///< rad, before closing
  ActuatorVector closed;            ///< rad, where closing ends at the latest
  ActuatorVector contact_torque;    ///< N m, with which each actuator closes at most
  std::vector<Attitude> attitudes;  ///< of the mount; the usual one first
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  ///< of the mount from the object, its axes, m
  double height = 0;                                 ///< of the mount above the table, m
};

/// The hand with one finger stretched, whose tip is far ahead of all else.
struct PointingHand {
  int finger = 0;
  ActuatorVector positions;  ///< rad
  Attitude attitude;         ///< of the mount in which the finger points down
};

/// The hand with a level underside.
struct FlatHand {
  ActuatorVector positions;                          ///< rad
  Attitude attitude;                                 ///< of the mount in which it is level
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< of it, in the mount's horizontal axes, m
};

/// The postures that skills ask for.
struct Postures {
  FlatHand flat;
  std::vector<PointingHand> pointing;   ///< the best first; one a finger that can
  ActuatorVector stretched, folded;     ///< all fingers out of the way of one that moves, rad
  ActuatorVector released;              ///< rad, beyond which no actuator stays bent in letting go
  Preshape top, side;                   ///< for grasps from above, and from the side
  std::vector<Attitude> far_attitudes;  ///< from which what is held can be turned farthest
};

/// Where a simulator finds the hand.
struct ModelFile {
  std::filesystem::path path;   ///< MJCF or URDF
  std::string root;             ///< its first body
  std::string prefix;           ///< that links and joints have there before their names
  std::string actuator_prefix;  ///< and actuators
  bool own_servos = false;  ///< the file's actuators are used; else Description::actuators' gains
  /// Where the mount carries the first body.
  Eigen::Isometry3d T_mount_root = Eigen::Isometry3d::Identity();
  /// Bodies that overlap in every posture, and are let.
  std::vector<std::pair<std::string, std::string>> overlapping = {};
};

/// A hand as plain data, enough to move it, to know where its links are and what they sense. It is
/// written into every recording, so that kinematics need no simulator.
///
/// The mount's frame is where the hand is carried: palm down, fingers along +x, z up, its origin
/// where the hand grasps.
struct Description {
  std::string name;
  std::vector<Link> links;  ///< parents first, from the mount
  int palm = -1;            ///< link of the palm
  std::vector<Joint> joints;
  std::vector<Actuator> actuators;
  std::vector<Finger> fingers;
  int thumb = 0;  ///< the finger that closes against the others
  std::vector<LinkSphere> spheres;
  Postures postures;
  ModelFile file;
  /// By how much each link that may_be_misplaced() is believed to be, root mean square, m.
  double kinematic_error = 0;

  int joint_count() const { return static_cast<int>(joints.size()); }
  int actuator_count() const { return static_cast<int>(actuators.size()); }
  int finger_count() const { return static_cast<int>(fingers.size()); }

  /// @throws BadInput for a name that is not the hand's
  int joint(std::string_view named) const;
  int actuator(std::string_view named) const;

  /// The finger that opposes the thumb most squarely: the middle one of the others.
  int middle_finger() const;
};

/// Where an actuator stands in a straight finger, rad: 0 or the end nearest to it; the end away
/// from closed, if that would leave less than a fifth of the range on the way to closed.
double straight_command(const Actuator& actuator);

/// Where an actuator stands in a closed finger, rad.
double closed_command(const Actuator& actuator);

/// Actuators of a finger that close it, in order from the palm.
std::vector<int> closing_actuators(const Description& hand, int finger);

/// The actuator that moves a finger sideways; nothing for a finger without.
std::optional<int> spreading_actuator(const Description& hand, int finger);

}  // namespace palpate::hand
