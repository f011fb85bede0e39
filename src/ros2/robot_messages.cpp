// SPDX-License-Identifier: Apache-2.0
#include "palpate/ros2/robot_messages.hpp"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "palpate/core/error.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::ros2 {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr double kUnitTolerance = 0.01;

Point point_of(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }
Vector3 vector_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Quaternion quaternion_of(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return {q.x(), q.y(), q.z(), q.w()};
}

JointState joint_state(const Header& header, const std::vector<std::string>& names,
                       const Eigen::VectorXd& positions, const Eigen::VectorXd& effort) {
  const auto values = [](const Eigen::VectorXd& v) {
    return std::vector<double>(v.data(), v.data() + v.size());
  };
  return {header, names, values(positions), {}, values(effort)};
}

template <class Named>
std::vector<std::string> names_of(const std::vector<Named>& items) {
  std::vector<std::string> names;
  for (const Named& item : items) names.push_back(item.name);
  return names;
}

/// Of [rotation; translation] as ROS has it, of [translation; rotation].
std::array<double, 36> ros_covariance(const Matrix6d& covariance) {
  std::array<double, 36> values{};
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      values[static_cast<std::size_t>(6 * i + j)] = covariance((i + 3) % 6, (j + 3) % 6);
    }
  }
  return values;
}

/// As opaque as the mode is probable.
Marker mode_marker(const localization::Mode& mode, const Eigen::AlignedBox3d& bounds,
                   const Header& header) {
  Marker marker;
  marker.header = header;
  marker.ns = "modes";
  marker.type = Marker::kCube;
  const Eigen::Isometry3d T_object_box(Eigen::Translation3d(bounds.center()));
  marker.pose = pose_of(mode.T_frame_object * T_object_box);
  marker.scale = vector_of(bounds.sizes());
  marker.color = {0.2F, 0.5F, 1.0F, static_cast<float>(0.5 * mode.weight)};
  return marker;
}

Marker contacts_marker(const std::vector<tactile::Contact>& contacts, const Header& header) {
  Marker marker;
  marker.header = header;
  marker.ns = "contacts";
  marker.type = Marker::kSphereList;
  marker.scale = {0.004, 0.004, 0.004};
  marker.color = {1.0F, 0.5F, 0.0F, 1.0F};
  for (const auto& contact : contacts) marker.points.push_back(point_of(contact.p));
  return marker;
}

}  // namespace

Time stamp_of(std::uint64_t nanoseconds) {
  return {static_cast<std::int32_t>(nanoseconds / kSecond),
          static_cast<std::uint32_t>(nanoseconds % kSecond)};
}

std::uint64_t nanoseconds_of(const Time& stamp) {
  if (stamp.sec < 0) return 0;
  return static_cast<std::uint64_t>(stamp.sec) * kSecond + stamp.nanosec;
}

std::uint64_t nanoseconds_of(double seconds) {
  return static_cast<std::uint64_t>(std::llround(std::max(0.0, seconds) * 1e9));
}

Pose pose_of(const Eigen::Isometry3d& T) {
  return {point_of(T.translation()), quaternion_of(T.linear())};
}

Eigen::Isometry3d transform_of(const Pose& pose) {
  const Eigen::Vector3d p(pose.position.x, pose.position.y, pose.position.z);
  check_plausible(p, kMaxLength, "a translation");
  const Quaternion& r = pose.orientation;
  const Eigen::Quaterniond q(r.w, r.x, r.y, r.z);
  if (!(std::abs(q.norm() - 1) < kUnitTolerance)) {
    throw BadInput(fmt::format("a rotation by a quaternion of length {}", q.norm()));
  }
  return Eigen::Translation3d(p) * q.normalized();
}

Eigen::Isometry3d transform_of(const Transform& transform) {
  const Vector3& t = transform.translation;
  return transform_of(Pose{{t.x, t.y, t.z}, transform.rotation});
}

TransformStamped transform_stamped(const Time& stamp, const std::string& parent,
                                   const std::string& child, const Eigen::Isometry3d& T) {
  return {{stamp, parent}, child, {vector_of(T.translation()), quaternion_of(T.linear())}};
}

ReadingMessages messages_of(const hand::HandReading& reading, const hand::Description& hand,
                            const RobotInterface& interface, std::uint64_t time) {
  const Time stamp = stamp_of(time);
  ReadingMessages messages;
  messages.joints =
      joint_state({stamp, interface.mount}, names_of(hand.joints), reading.joints, {});
  messages.actuators = joint_state({stamp, interface.mount}, names_of(hand.actuators),
                                   hand::actuator_positions(hand, reading.joints), reading.torques);
  messages.wrench = {{stamp, interface.world}, {vector_of(reading.mount_force), {}}};
  auto& transforms = messages.tf.transforms;
  transforms.push_back(
      transform_stamped(stamp, interface.world, interface.mount, reading.mount.pose()));
  const auto T_mount_link = hand::forward_kinematics(hand, reading.joints);
  std::set<int> links = {hand.palm};
  for (std::size_t i = 0; i < hand.fingers.size(); ++i) {
    const auto& finger = hand.fingers[i];
    messages.contacts.push_back(cloud_of(reading.contacts[i], {stamp, tip_frame(hand, finger)}));
    links.insert(finger.link);
  }
  for (const int link : links) {
    const auto i = static_cast<std::size_t>(link);
    if (link < 0 || hand.links[i].name == interface.mount) continue;
    transforms.push_back(
        transform_stamped(stamp, interface.mount, hand.links[i].name, T_mount_link[i]));
  }
  return messages;
}

EstimateMessages messages_of(const localization::Posterior& posterior,
                             const std::vector<tactile::Contact>& contacts,
                             const Eigen::AlignedBox3d& bounds, const RobotInterface& interface,
                             std::uint64_t time) {
  const Header header{stamp_of(time), interface.world};
  EstimateMessages messages;
  messages.modes.header = header;
  messages.status.data = localization::to_string(posterior.status);
  Marker clear;
  clear.header = header;
  clear.action = Marker::kDeleteAll;
  messages.markers.markers = {clear, contacts_marker(contacts, header)};
  for (const auto& mode : posterior.modes) {
    messages.modes.poses.push_back(pose_of(mode.T_frame_object));
    messages.weights.data.push_back(mode.weight);
    messages.markers.markers.push_back(mode_marker(mode, bounds, header));
    messages.markers.markers.back().id = static_cast<int>(messages.modes.poses.size());
  }
  messages.weights.layout.dim = {{"modes", static_cast<std::uint32_t>(posterior.modes.size()),
                                  static_cast<std::uint32_t>(posterior.modes.size())}};
  if (posterior.modes.empty()) return messages;
  const auto& best = posterior.modes.front();
  messages.pose = {
      {header,
       {pose_of(best.T_frame_object), ros_covariance(localization::family_covariance(best))}}};
  messages.tf.transforms = {
      transform_stamped(header.stamp, interface.world, kObjectFrame, best.T_frame_object)};
  return messages;
}

MarkerArray object_marker(const geometry::TriangleMesh& mesh) {
  Marker marker;
  marker.header.frame_id = kObjectFrame;
  marker.ns = "object";
  marker.type = Marker::kTriangleList;
  marker.scale = {1, 1, 1};
  marker.color = {0.3F, 0.8F, 0.4F, 1.0F};
  marker.frame_locked = true;
  for (const auto& triangle : mesh.triangles) {
    for (const int corner : triangle) {
      marker.points.push_back(point_of(mesh.vertices[static_cast<std::size_t>(corner)]));
    }
  }
  return {{marker}};
}

}  // namespace palpate::ros2
