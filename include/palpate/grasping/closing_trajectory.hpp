// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/grasping/closing_law.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::grasping {

/// Points of one finger, in the mount's frame, at one instant of its closing.
struct FingerShape {
  /// On the axis of the fingertip's capsule, or spread over its hull's core; the axis' outer end
  /// last.
  std::vector<Eigen::Vector3f> tip;
  std::vector<Eigen::Vector4f> other_spheres;  ///< of its other links: center and radius, m
};

/// How an empty hand closes: the shapes that its fingers pass through, in the mount's frame, m.
struct ClosingTrajectory {
  std::vector<Eigen::Vector4f> open_spheres;  ///< of the whole hand before closing
  std::vector<std::vector<FingerShape>> fingers;
  hand::PerFinger<float> tip_radius{};
  std::size_t thumb = 0, middle = 0;  ///< the fingers that close squarely against one another
};

/// Every finger of any hand.
inline constexpr hand::PerFinger<bool> kAllFingers = {true, true, true, true,
                                                      true, true, true, true};

/// @param law  of the closing; its rates say how the joints move in proportion
/// @param closing  the fingers that close; the others have no shapes
ClosingTrajectory closing_trajectory(const hand::Description& hand,
                                     const hand::ActuatorVector& open,
                                     const grasping::ClosingLaw& law,
                                     const hand::PerFinger<bool>& closing = kAllFingers);

/// Ends the path of a finger before it meets the other fingers, which stand still at these joints.
void end_at_other_fingers(const hand::Description& hand, const hand::JointVector& joints,
                          std::size_t finger, ClosingTrajectory& path);

/// An object at a pose above the table, asked from the hand's mount.
class PlacedObject {
 public:
  PlacedObject(const geometry::ObjectModel& object, const Eigen::Isometry3d& T_world_object,
               const Eigen::Isometry3d& T_world_mount);
  /// Signed distance of a point in the mount's frame from the object's surface, m; negative inside,
  /// infinite far from the object, where the field ends.
  float distance(const Eigen::Vector3f& p) const;
  /// Height of a point in the mount's frame above the table, m.
  float height(const Eigen::Vector3f& p) const;
  /// Outward normal of the object at a point (mount's frame) near its surface, in the mount's axes.
  Eigen::Vector3d normal(const Eigen::Vector3f& p) const;

 private:
  const geometry::DistanceField& field_;
  Eigen::Isometry3f T_object_mount_, T_world_mount_;
};

/// Where a closing finger stops, and the contact of its tip if that is why.
struct FingerMeeting {
  std::size_t stop = 0;                     ///< index of its shape
  std::optional<tactile::Contact> contact;  ///< in the mount's frame
};

/// Closes a finger along its path, which must have a shape, until its tip or another of its links
/// meets the object, or its tip the table.
/// @param min_height  of the tip above the table, m; lower counts as meeting it
FingerMeeting meet(const PlacedObject& object, const ClosingTrajectory& path, std::size_t finger,
                   double min_height);

}  // namespace palpate::grasping
