// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

struct ClosestPoint {
  Eigen::Vector3d point;   ///< on the surface
  Eigen::Vector3d normal;  ///< outward pseudonormal of the face, edge or vertex it lies on, unit
  double distance = 0;     ///< m, >= 0
  int triangle = -1;
};

struct RayHit {
  double distance = 0;  ///< m along the unit direction
  int triangle = -1;
};

/// Exact closest-point, inside and ray queries on a triangle mesh through a bounding-volume tree.
/// Immutable after construction, so that threads may share it.
class MeshQuery {
 public:
  /// @throws BadInput for a mesh without triangles
  explicit MeshQuery(TriangleMesh mesh);
  ~MeshQuery();
  MeshQuery(MeshQuery&&) noexcept;
  MeshQuery& operator=(MeshQuery&&) noexcept;

  const TriangleMesh& mesh() const;

  /// @param guess  a triangle thought to be near p, which only makes the search faster
  /// @throws BadInput if p is not finite
  ClosestPoint closest_point(const Eigen::Vector3d& p, int guess = -1) const;

  /// Whether p lies inside: the majority of the crossings' parities along three fixed rays, which
  /// slivers cannot mislead as they do pseudonormals. The mesh is watertight.
  bool inside(const Eigen::Vector3d& p) const;

  /// Distance to the surface, negative where `inside`.
  double signed_distance(const Eigen::Vector3d& p) const;

  /// First triangle along origin + s direction, 0 <= s <= reach.
  std::optional<RayHit> raycast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                double reach) const;

 private:
  struct Tree;
  std::unique_ptr<const Tree> tree_;
};

}  // namespace palpate::geometry
