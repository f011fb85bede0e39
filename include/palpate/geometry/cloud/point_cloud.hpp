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

/// @throws BadInput, naming the point, for a coordinate that is not finite, a normal that is not of
///         unit length to 1e-3, or normals of another number than points
void check_cloud(const PointCloud& cloud);

/// The points (and normals) that `indices` names, in that order.
PointCloud subset(const PointCloud& cloud, const std::vector<int>& indices);

/// The cloud moved by T.
PointCloud transformed(const Eigen::Isometry3d& T, PointCloud cloud);

/// One point for each cube of a grid that holds points: their mean, with the mean of their normals
/// made a unit vector. In the order in which the cubes are first met.
/// @param cell  side of the cubes, m
/// @throws BadInput unless the cell is positive and finite, and as check_cloud()
PointCloud voxel_sampled(const PointCloud& cloud, double cell);

/// Smallest cell (to a few per cent) with which voxel_sampled() leaves at most `most` points; 0 for
/// a cloud that has no more than that.
double voxel_cell_for(const PointCloud& cloud, std::size_t most);

}  // namespace palpate::geometry
