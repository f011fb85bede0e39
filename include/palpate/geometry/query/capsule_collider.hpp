// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "palpate/geometry/query/mesh_query.hpp"

namespace palpate::geometry {

/// All points within `radius` of the segment from a to b; a ball if they are equal. In metres.
struct Capsule {
  Eigen::Vector3d a, b;
  double radius = 0;
};

/// Where a capsule and a surface are closest, locally.
struct CapsuleContact {
  Eigen::Vector3d point;   ///< on the mesh's surface
  Eigen::Vector3d normal;  ///< outward unit normal of the mesh there, towards the capsule's axis
  double distance = 0;     ///< between the two surfaces, negative where they overlap, m
};

/// Contacts of capsules with the true surface of a watertight, possibly concave mesh. Immutable
/// after construction, so that threads may share it.
class CapsuleCollider {
 public:
  /// Keeps a reference: the mesh must outlive the collider.
  explicit CapsuleCollider(const MeshQuery& mesh);
  ~CapsuleCollider();
  CapsuleCollider(CapsuleCollider&&) noexcept;

  /// Local minima of the distance between the surfaces that are below `margin` (m), deepest first,
  /// at most `limit`. They differ by 15 degrees in normal or by 6 mm in place; of two that must
  /// share little room the second is preferably one of a different normal. Where the axis' end lies
  /// inside the mesh the contact leads it out the shortest way.
  std::vector<CapsuleContact> contacts(const Capsule& capsule, double margin, int limit) const;

 private:
  struct Surface;
  std::unique_ptr<const Surface> surface_;
};

}  // namespace palpate::geometry
