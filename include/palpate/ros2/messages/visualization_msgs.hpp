// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/ros2/messages/geometry_msgs.hpp"
#include "palpate/ros2/messages/sensor_msgs.hpp"

namespace palpate::ros2 {

struct UVCoordinate {
  static constexpr std::string_view kType = "visualization_msgs/msg/UVCoordinate";
  float u = 0, v = 0;
  static void fields(auto& m, auto&& visit) {
    visit("u", m.u);
    visit("v", m.v);
  }
};

struct MeshFile {
  static constexpr std::string_view kType = "visualization_msgs/msg/MeshFile";
  std::string filename;
  std::vector<std::uint8_t> data;
  static void fields(auto& m, auto&& v) {
    v("filename", m.filename);
    v("data", m.data);
  }
};

struct Marker {
  static constexpr std::string_view kType = "visualization_msgs/msg/Marker";
  static constexpr std::int32_t kArrow = 0, kCube = 1, kSphereList = 7, kTriangleList = 11;
  static constexpr std::int32_t kAdd = 0, kDeleteAll = 3;
  Header header;
  std::string ns;
  std::int32_t id = 0, type = 0, action = 0;
  Pose pose;
  Vector3 scale;
  ColorRGBA color;
  Duration lifetime;
  bool frame_locked = false;
  std::vector<Point> points;
  std::vector<ColorRGBA> colors;
  std::string texture_resource;
  CompressedImage texture;
  std::vector<UVCoordinate> uv_coordinates;
  std::string text, mesh_resource;
  MeshFile mesh_file;
  bool mesh_use_embedded_materials = false;
  static void fields(auto& m, auto&& v) {
    v("header", m.header);
    v("ns", m.ns);
    v("id", m.id);
    v("type", m.type);
    v("action", m.action);
    v("pose", m.pose);
    v("scale", m.scale);
    v("color", m.color);
    v("lifetime", m.lifetime);
    v("frame_locked", m.frame_locked);
    v("points", m.points);
    v("colors", m.colors);
    v("texture_resource", m.texture_resource);
    v("texture", m.texture);
    v("uv_coordinates", m.uv_coordinates);
    v("text", m.text);
    v("mesh_resource", m.mesh_resource);
    v("mesh_file", m.mesh_file);
    v("mesh_use_embedded_materials", m.mesh_use_embedded_materials);
  }
};

struct MarkerArray {
  static constexpr std::string_view kType = "visualization_msgs/msg/MarkerArray";
  std::vector<Marker> markers;
  static void fields(auto& m, auto&& v) { v("markers", m.markers); }
};

}  // namespace palpate::ros2
