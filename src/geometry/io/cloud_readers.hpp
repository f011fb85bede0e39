// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "palpate/core/se3.hpp"
#include "palpate/geometry/cloud/point_cloud.hpp"

namespace palpate::geometry {

/// Collects the points that a file holds and checks them.
class CloudBuilder {
 public:
  explicit CloudBuilder(std::string_view file) : file_(file) {}

  /// @param point  {x, y, z, nx, ny, nz}; nan for a normal that the file lacks
  /// @throws BadInput for a position that is not finite
  void add(const Vector6d& point);

  /// The cloud; with normals if every point has one of some length, made unit vectors.
  PointCloud finish() &&;

 private:
  std::string file_;
  PointCloud cloud_;
  bool all_normals_ = true;
};

/// Each reads the content of a file of its format; `file` is for messages.
/// @throws BadInput as load_cloud does
PointCloud read_ply_cloud(std::string_view content, std::string_view file);
PointCloud read_pcd(std::string_view content, std::string_view file);
PointCloud read_xyz(std::string_view content, std::string_view file);

}  // namespace palpate::geometry
