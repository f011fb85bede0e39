// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace palpate::geometry {

/// Points in metres, with or without normals.
struct PointCloud {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> normals;  ///< unit; empty, or one a point

  std::size_t size() const { return points.size(); }
  bool has_normals() const { return !normals.empty(); }
};

/// Points in someone else's memory, with or without normals: nothing is copied, and the memory must
/// outlive the view.
class PointView {
 public:
  /// @throws BadInput for normals of another number than points
  PointView(const PointCloud& cloud);  // NOLINT: a cloud is seen as what it is

  /// Rows of x, y, z in metres, one every `stride` bytes: of an Eigen matrix of 3 rows m, a map or
  /// a block of one, PointView(m.data(), m.cols(), m.outerStride() * sizeof(double)).
  PointView(const double* points, std::size_t count, std::ptrdiff_t stride = 3 * sizeof(double));
  PointView(const float* points, std::size_t count, std::ptrdiff_t stride = 3 * sizeof(float));

  /// The same points with unit normals, of the points' type, one every `stride` bytes.
  PointView with_normals(const void* normals, std::ptrdiff_t stride) const;

  std::size_t size() const { return size_; }
  bool has_normals() const { return normals_ != nullptr; }
  Eigen::Vector3d point(std::size_t i) const { return at(points_, stride_, i); }
  Eigen::Vector3d normal(std::size_t i) const { return at(normals_, normal_stride_, i); }

 private:
  Eigen::Vector3d at(const std::byte* rows, std::ptrdiff_t stride, std::size_t i) const {
    const std::byte* row = rows + stride * static_cast<std::ptrdiff_t>(i);
    if (!is_float_) return Eigen::Map<const Eigen::Vector3d>(reinterpret_cast<const double*>(row));
    return Eigen::Map<const Eigen::Vector3f>(reinterpret_cast<const float*>(row)).cast<double>();
  }

  const std::byte* points_ = nullptr;
  const std::byte* normals_ = nullptr;
  std::size_t size_ = 0;
  std::ptrdiff_t stride_ = 0, normal_stride_ = 0;
  bool is_float_ = false;
};

/// A copy of its own.
PointCloud copied(const PointView& view);

/// @throws BadInput, naming the point, for a coordinate that is not finite, a normal that is not of
///         unit length to 1e-3
void check_cloud(const PointView& cloud);

/// The points (and normals) that `indices` names, in that order.
PointCloud subset(const PointCloud& cloud, const std::vector<int>& indices);

/// The cloud moved by T.
PointCloud transformed(const Eigen::Isometry3d& T, PointCloud cloud);

/// One point for each cube of a grid that holds points: their mean, with the mean of their normals
/// made a unit vector. In the order in which the cubes are first met.
/// @param cell  side of the cubes, m
/// @throws BadInput unless the cell is positive and finite, and as check_cloud()
PointCloud voxel_sampled(const PointView& cloud, double cell);

/// Smallest cell (to a few per cent) with which voxel_sampled() leaves at most `most` points; 0 for
/// a cloud that has no more than that.
double voxel_cell_for(const PointView& cloud, std::size_t most);

}  // namespace palpate::geometry
