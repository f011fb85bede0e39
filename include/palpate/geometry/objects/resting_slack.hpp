// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "palpate/geometry/objects/known_object.hpp"

namespace palpate::geometry {

/// How far an object leans from a stable pose before its centroid rises noticeably. Where that
/// takes little, as about the axis of a lying bottle, small errors of its surface move where it
/// comes to rest.
class RestingSlack {
 public:
  /// @param pose  a stable pose of the mesh, whose volume centroid is the origin
  RestingSlack(const TriangleMesh& mesh, const StablePose& pose);

  /// Unit directions, in the object's frame, in which the plane's normal leans: the first where the
  /// centroid rises least, the second across it.
  const std::array<Eigen::Vector3d, 2>& directions() const { return directions_; }

  /// Lean (rad, at most 0.32) at which the centroid has risen by `rise` (m), in the first or the
  /// second direction, to the side where that is more.
  double lean(int direction, double rise) const;

 private:
  static constexpr std::array<double, 6> kLeans = {0.01, 0.02, 0.04, 0.08, 0.16, 0.32};  // rad
  using Rises = std::array<double, kLeans.size()>;
  static Rises rises(const TriangleMesh& mesh, const Eigen::Vector3d& up,
                     const Eigen::Vector3d& direction);

  std::array<Eigen::Vector3d, 2> directions_;
  std::array<Rises, 2> rises_;
};

}  // namespace palpate::geometry
