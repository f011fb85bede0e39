// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "geometry/mesh/adjacency.hpp"
#include "geometry/mesh/pseudonormals.hpp"
#include "geometry/query/bvh.hpp"
#include "palpate/geometry/query/capsule_collider.hpp"

namespace palpate::geometry {

inline constexpr double kOnSurface = 1e-9;  // m, below which directions come from the surface

/// The place on the axis, or on a hull's core, and the place on a triangle's feature that are
/// closest to one another.
struct Candidate {
  Eigen::Vector3d p, q;  // on the axis, on the surface
  int triangle = -1;
  Feature feature = Feature::kFace;
  double gap = 0;  // signed distance between the surfaces
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  bool is_proven = false;    // no neighbour needs to be asked
  bool is_interior = false;  // p is no end of the axis

  double length() const { return (p - q).norm(); }
};

/// The ball around a triangle's middle.
struct Bound {
  Eigen::Vector3d center;
  double radius = 0;  // negative for a degenerate triangle, which nothing needs to meet
};

/// Closest points of the axis' interior and an edge (Ericson, Real-Time Collision Detection, 2004,
/// 5.1.9); none if the axis is closest with an end, or parallel, which its ends show.
std::optional<Candidate> axis_to_edge(const Capsule& capsule, const Corners& t, int k);

Bound bound_of(const Corners& t);

double squared_distance_to_axis(const Capsule& capsule, const Eigen::Vector3d& p);

/// Whether the axis stays farther than `reach` from a plane.
bool is_beyond(const Capsule& capsule, double reach, const Eigen::Vector3d& on_plane,
               const Eigen::Vector3d& normal);

struct CapsuleCollider::Surface {
  explicit Surface(const MeshQuery& source)
      : query(source), bvh(source.mesh()), normals(source.mesh()), adjacency(source.mesh()) {
    for (const auto& triangle : source.mesh().triangles) {
      bounds.push_back(bound_of(corners(source.mesh(), triangle)));
    }
  }

  Corners corners_of(int triangle) const {
    return corners(query.mesh(), query.mesh().triangles[static_cast<std::size_t>(triangle)]);
  }
  std::vector<Candidate> outside_candidates(const Capsule& capsule, double reach) const;
  std::vector<Candidate> candidates(const Capsule& capsule, double reach) const;
  void resolve_end(const Capsule& capsule, const Eigen::Vector3d& end,
                   const std::vector<Candidate>& all, std::vector<Candidate>& kept) const;
  void erase_seen_from_behind(double radius, std::vector<Candidate>& kept) const;
  Eigen::Vector3d pseudonormal(const Candidate& c) const {
    return normals.at(c.triangle, c.feature);
  }
  bool is_flat(const Candidate& c) const;
  bool is_local_minimum(const Candidate& c) const;
  void select(const std::vector<Candidate>& sorted, bool new_normals_only, std::size_t limit,
              std::vector<CapsuleContact>& chosen) const;
  std::vector<CapsuleContact> chosen(std::vector<Candidate> found, double margin, int limit) const;

  const MeshQuery& query;
  Bvh bvh;
  Pseudonormals normals;
  Adjacency adjacency;
  std::vector<Bound> bounds;  // of the triangles
};

}  // namespace palpate::geometry
