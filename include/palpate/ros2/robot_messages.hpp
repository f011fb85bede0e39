// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "palpate/core/se3.hpp"
#include "palpate/geometry/mesh/mesh.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/localization/posterior.hpp"
#include "palpate/ros2/messages/diagnostic_msgs.hpp"
#include "palpate/ros2/messages/geometry_msgs.hpp"
#include "palpate/ros2/messages/sensor_msgs.hpp"
#include "palpate/ros2/messages/std_msgs.hpp"
#include "palpate/ros2/messages/visualization_msgs.hpp"
#include "palpate/ros2/robot_interface.hpp"
#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::ros2 {

Time stamp_of(std::uint64_t nanoseconds);
/// ns since the epoch; what lies before it is 0.
std::uint64_t nanoseconds_of(const Time& stamp);
/// Seconds as ns; what is negative is 0.
std::uint64_t nanoseconds_of(double seconds);

Pose pose_of(const Eigen::Isometry3d& T);
/// @throws BadInput for values that are not finite or beyond kMaxLength, or a quaternion that is
///         not of unit length within 1 %
Eigen::Isometry3d transform_of(const Transform& transform);
Eigen::Isometry3d transform_of(const Pose& pose);  ///< the same
TransformStamped transform_stamped(const Time& stamp, const std::string& parent,
                                   const std::string& child, const Eigen::Isometry3d& T);

/// Contacts as points with the fields x, y, z, normal_x, normal_y, normal_z, force_x, force_y,
/// force_z, point_sigma and normal_sigma, all 32-bit floats, in SI units. As in hand::TipContact:
/// the normal is the outward one of the object, the force that of the finger on the object.
PointCloud2 cloud_of(const std::vector<hand::TipContact>& contacts, const Header& header);

/// The contacts of such a cloud. Of the fields only x, y, z must be there, as 32 or 64-bit floats;
/// a point without a normal has a zero one. Points that are not finite are left out.
/// @throws BadInput for a cloud whose fields do not lie within its data, in big endian, with more
///         than 10000 points, or with values beyond what can be
std::vector<hand::TipContact> contacts_of(const PointCloud2& cloud);

/// What a hand publishes of one reading.
struct ReadingMessages {
  JointState joints;                  ///< positions of the joints
  JointState actuators;               ///< positions of the actuators, with their torques as effort
  std::vector<PointCloud2> contacts;  ///< one a finger, in the frame of its distal link
  WrenchStamped wrench;               ///< mount_force, in the world's axes
  TFMessage tf;                       ///< of the mount, the palm and the distal links
};
ReadingMessages messages_of(const hand::HandReading& reading, const hand::Description& hand,
                            const RobotInterface& interface, std::uint64_t time);

/// What an estimator publishes. A posterior without modes has no pose.
struct EstimateMessages {
  std::vector<PoseWithCovarianceStamped> pose;  ///< of the heaviest mode; one, or none
  PoseArray modes;                              ///< heaviest first
  Float64MultiArray weights;                    ///< of the modes, in the same order
  String status;                                ///< "certain", "ambiguous" or "no_pose"
  MarkerArray markers;                          ///< the modes' boxes, and the contacts
  TFMessage tf;                                 ///< of the heaviest mode: "palpate_object"
};
/// @param posterior  in the world
/// @param contacts   in the world
/// @param bounds     of the object, in its own frame
EstimateMessages messages_of(const localization::Posterior& posterior,
                             const std::vector<tactile::Contact>& contacts,
                             const Eigen::AlignedBox3d& bounds, const RobotInterface& interface,
                             std::uint64_t time);

inline constexpr const char* kObjectFrame = "palpate_object";

/// The object's mesh, in the frame kObjectFrame, which it follows.
MarkerArray object_marker(const geometry::TriangleMesh& mesh);

}  // namespace palpate::ros2
