// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "palpate/ros2/messages/std_msgs.hpp"

namespace palpate::ros2 {

struct Vector3 {
  static constexpr std::string_view kType = "geometry_msgs/msg/Vector3";
  double x = 0, y = 0, z = 0;
  static void fields(auto& m, auto&& v) {
    v("x", m.x);
    v("y", m.y);
    v("z", m.z);
  }
};

struct Point {
  static constexpr std::string_view kType = "geometry_msgs/msg/Point";
  double x = 0, y = 0, z = 0;
  static void fields(auto& m, auto&& v) {
    v("x", m.x);
    v("y", m.y);
    v("z", m.z);
  }
};

struct Quaternion {
  static constexpr std::string_view kType = "geometry_msgs/msg/Quaternion";
  double x = 0, y = 0, z = 0, w = 1;
  static void fields(auto& m, auto&& v) {
    v("x", m.x);
    v("y", m.y);
    v("z", m.z);
    v("w", m.w);
  }
};

struct Pose {
  static constexpr std::string_view kType = "geometry_msgs/msg/Pose";
  Point position;
  Quaternion orientation;
  static void fields(auto& m, auto&& v) {
    v("position", m.position);
    v("orientation", m.orientation);
  }
};

struct PoseStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/PoseStamped";
  Header header;
  Pose pose;
  static void fields(auto& m, auto&& v) {
    v("header", m.header);
    v("pose", m.pose);
  }
};

struct PoseWithCovariance {
  static constexpr std::string_view kType = "geometry_msgs/msg/PoseWithCovariance";
  Pose pose;
  std::array<double, 36> covariance{};  ///< of [translation; rotation], row-major
  static void fields(auto& m, auto&& v) {
    v("pose", m.pose);
    v("covariance", m.covariance);
  }
};

struct PoseWithCovarianceStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/PoseWithCovarianceStamped";
  Header header;
  PoseWithCovariance pose;
  static void fields(auto& m, auto&& v) {
    v("header", m.header);
    v("pose", m.pose);
  }
};

struct PoseArray {
  static constexpr std::string_view kType = "geometry_msgs/msg/PoseArray";
  Header header;
  std::vector<Pose> poses;
  static void fields(auto& m, auto&& v) {
    v("header", m.header);
    v("poses", m.poses);
  }
};

struct Wrench {
  static constexpr std::string_view kType = "geometry_msgs/msg/Wrench";
  Vector3 force, torque;
  static void fields(auto& m, auto&& v) {
    v("force", m.force);
    v("torque", m.torque);
  }
};

struct WrenchStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/WrenchStamped";
  Header header;
  Wrench wrench;
  static void fields(auto& m, auto&& v) {
    v("header", m.header);
    v("wrench", m.wrench);
  }
};

struct Transform {
  static constexpr std::string_view kType = "geometry_msgs/msg/Transform";
  Vector3 translation;
  Quaternion rotation;
  static void fields(auto& m, auto&& v) {
    v("translation", m.translation);
    v("rotation", m.rotation);
  }
};

struct TransformStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/TransformStamped";
  Header header;
  std::string child_frame_id;
  Transform transform;
  static void fields(auto& m, auto&& v) {
    v("header", m.header);
    v("child_frame_id", m.child_frame_id);
    v("transform", m.transform);
  }
};

/// Of the package tf2_msgs.
struct TFMessage {
  static constexpr std::string_view kType = "tf2_msgs/msg/TFMessage";
  std::vector<TransformStamped> transforms;
  static void fields(auto& m, auto&& v) { v("transforms", m.transforms); }
};

}  // namespace palpate::ros2
