// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/geometry/query/rounded_hull.hpp"

namespace palpate::geometry {

/// All points within `radius` of the segment from a to b; a ball if they are equal. In metres.
struct Capsule {
  Eigen::Vector3d a, b;
  double radius = 0;
};

/// Where a capsule, or another convex body, and a surface are closest, locally.
struct CapsuleContact {
  Eigen::Vector3d point;   ///< on the mesh's surface
  Eigen::Vector3d normal;  ///< outward unit normal of the mesh there, towards the axis or core
  double distance = 0;     ///< between the two surfaces, negative where they overlap, m
};

/// Contacts of capsules and of rounded convex hulls with the true surface of a watertight, possibly
/// concave mesh. Immutable after construction, so that threads may share it.
class CapsuleCollider {
 public:
  struct Surface;  ///< what the collider keeps of the mesh

  /// Keeps a reference: the mesh must outlive the collider.
  explicit CapsuleCollider(const MeshQuery& mesh);
  ~CapsuleCollider();
  CapsuleCollider(CapsuleCollider&&) noexcept;

  /// Local minima of the distance between the surfaces that are below `margin` (m), deepest first,
  /// at most `limit`. They differ by 15 degrees in normal or by 6 mm in place; of two that must
  /// share little room the second is preferably one of a different normal. Where the axis' end lies
  /// inside the mesh the contact leads it out the shortest way.
  std::vector<CapsuleContact> contacts(const Capsule& capsule, double margin, int limit) const;

  /// The same of a hull. Flat parts that meet have contacts at the corners of what they share. A
  /// hull that is sunk in by more than its edges' radius is led out the shortest way at its
  /// corners, and along its facets where the mesh's corners stand in it, as long as they are within
  /// 2 mm.
  std::vector<CapsuleContact> contacts(const RoundedHull& hull,
                                       const Eigen::Isometry3d& T_mesh_hull, double margin,
                                       int limit) const;

 private:
  std::unique_ptr<const Surface> surface_;
};

}  // namespace palpate::geometry
