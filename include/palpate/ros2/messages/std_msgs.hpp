// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// ROS 2's common messages as plain structs, of Humble and later. `fields` visits name and value of
/// every field in the order of the definition; serialization and schema are made from it.
namespace palpate::ros2 {

struct Time {
  static constexpr std::string_view kType = "builtin_interfaces/msg/Time";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  static void fields(auto& m, auto&& v) {
    v("sec", m.sec);
    v("nanosec", m.nanosec);
  }
};

struct Duration {
  static constexpr std::string_view kType = "builtin_interfaces/msg/Duration";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  static void fields(auto& m, auto&& v) {
    v("sec", m.sec);
    v("nanosec", m.nanosec);
  }
};

struct Header {
  static constexpr std::string_view kType = "std_msgs/msg/Header";
  Time stamp;
  std::string frame_id;
  static void fields(auto& m, auto&& v) {
    v("stamp", m.stamp);
    v("frame_id", m.frame_id);
  }
};

struct String {
  static constexpr std::string_view kType = "std_msgs/msg/String";
  std::string data;
  static void fields(auto& m, auto&& v) { v("data", m.data); }
};

struct ColorRGBA {
  static constexpr std::string_view kType = "std_msgs/msg/ColorRGBA";
  float r = 0, g = 0, b = 0, a = 0;
  static void fields(auto& m, auto&& v) {
    v("r", m.r);
    v("g", m.g);
    v("b", m.b);
    v("a", m.a);
  }
};

struct MultiArrayDimension {
  static constexpr std::string_view kType = "std_msgs/msg/MultiArrayDimension";
  std::string label;
  std::uint32_t size = 0, stride = 0;
  static void fields(auto& m, auto&& v) {
    v("label", m.label);
    v("size", m.size);
    v("stride", m.stride);
  }
};

struct MultiArrayLayout {
  static constexpr std::string_view kType = "std_msgs/msg/MultiArrayLayout";
  std::vector<MultiArrayDimension> dim;
  std::uint32_t data_offset = 0;
  static void fields(auto& m, auto&& v) {
    v("dim", m.dim);
    v("data_offset", m.data_offset);
  }
};

struct Float64MultiArray {
  static constexpr std::string_view kType = "std_msgs/msg/Float64MultiArray";
  MultiArrayLayout layout;
  std::vector<double> data;
  static void fields(auto& m, auto&& v) {
    v("layout", m.layout);
    v("data", m.data);
  }
};

struct Float32MultiArray {
  static constexpr std::string_view kType = "std_msgs/msg/Float32MultiArray";
  MultiArrayLayout layout;
  std::vector<float> data;
  static void fields(auto& m, auto&& v) {
    v("layout", m.layout);
    v("data", m.data);
  }
};

}  // namespace palpate::ros2
