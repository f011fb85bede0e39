// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/ros2/messages/std_msgs.hpp"

namespace palpate::ros2 {

struct JointState {
  static constexpr std::string_view kType = "sensor_msgs/msg/JointState";
  Header header;
  std::vector<std::string> name;
  std::vector<double> position, velocity, effort;
  static void fields(auto& m, auto&& v) {
    v("header", m.header);
    v("name", m.name);
    v("position", m.position);
    v("velocity", m.velocity);
    v("effort", m.effort);
  }
};

struct PointField {
  static constexpr std::string_view kType = "sensor_msgs/msg/PointField";
  static constexpr std::uint8_t kFloat32 = 7, kFloat64 = 8;
  std::string name;
  std::uint32_t offset = 0;
  std::uint8_t datatype = 0;
  std::uint32_t count = 0;
  static void fields(auto& m, auto&& v) {
    v("name", m.name);
    v("offset", m.offset);
    v("datatype", m.datatype);
    v("count", m.count);
  }
};

struct PointCloud2 {
  static constexpr std::string_view kType = "sensor_msgs/msg/PointCloud2";
  Header header;
  std::uint32_t height = 0, width = 0;
  std::vector<PointField> point_fields;  ///< "fields"
  bool is_bigendian = false;
  std::uint32_t point_step = 0, row_step = 0;
  std::vector<std::uint8_t> data;
  bool is_dense = false;
  static void fields(auto& m, auto&& v) {
    v("header", m.header);
    v("height", m.height);
    v("width", m.width);
    v("fields", m.point_fields);
    v("is_bigendian", m.is_bigendian);
    v("point_step", m.point_step);
    v("row_step", m.row_step);
    v("data", m.data);
    v("is_dense", m.is_dense);
  }
};

struct CompressedImage {
  static constexpr std::string_view kType = "sensor_msgs/msg/CompressedImage";
  Header header;
  std::string format;
  std::vector<std::uint8_t> data;
  static void fields(auto& m, auto&& v) {
    v("header", m.header);
    v("format", m.format);
    v("data", m.data);
  }
};

}  // namespace palpate::ros2
