// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "palpate/geometry/query/mesh_query.hpp"

namespace palpate::geometry {

/// Signed distance of a watertight mesh on a regular grid, with its gradient. Between nodes the
/// gradient is linear, and the distance corrected by it, which is exact for quadratic fields.
/// It takes up to a second, so it is kept in the cache under the mesh's content.
class DistanceField {
 public:
  struct Sample {
    float distance;            ///< m, negative inside
    Eigen::Vector3f gradient;  ///< interpolated outward direction; its length is <= 1
    float squared_curvature;   ///< mean square of the level set's principal curvatures, 1/m^2
  };

  /// @param cell  grid spacing, m
  /// @param padding  how far the grid reaches beyond the mesh's bounds, m
  DistanceField(const MeshQuery& mesh, double cell = 0.002, double padding = 0.03);

  /// Interpolated value at p (in the mesh's frame); nothing outside the grid.
  std::optional<Sample> at(const Eigen::Vector3f& p) const;

  /// The cell of the grid that holds a point.
  struct Cell {
    const Eigen::Vector4f* node;  ///< its first; null outside the grid
    Eigen::Array3f t;             ///< the place in it, 0..1 along each axis
  };
  /// Where p is, for at() and distance() a little later: the nodes, which mostly are not in the
  /// processor's cache, are fetched meanwhile.
  Cell fetched(const Eigen::Vector3f& p) const;
  /// As below.
  /// @param cell  inside the grid
  Sample at(const Cell& cell) const;
  float distance(const Cell& cell) const;

  /// Interpolated distance at p; outside the grid `beyond()`.
  float distance(const Eigen::Vector3f& p) const;

  /// Value and gradient at any p. Outside the grid no more than the way to the nearest point of the
  /// grid and the distance there: at least the distance, and near it.
  Sample anywhere(const Eigen::Vector3f& p) const;

  /// Distance reported outside the grid: its padding, m.
  float beyond() const { return beyond_; }

 private:
  std::optional<Cell> cell_of(const Eigen::Vector3f& p) const;
  Cell cell_at(const Eigen::Array3f& at) const;
  struct Corners;
  Corners corners_of(const Cell& cell) const;
  bool take_nodes(std::string_view bytes);
  void fill(const MeshQuery& mesh);

  Eigen::Vector3f origin_;
  Eigen::Array3i size_;
  float cell_, beyond_;
  std::vector<Eigen::Vector4f> nodes_;  // gradient and distance, z fastest
};

}  // namespace palpate::geometry
