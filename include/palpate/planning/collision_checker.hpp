// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "palpate/hand/hand.hpp"

namespace palpate::planning {

/// Two bodies that overlap: links of the hand, "table", "fixture" or "object".
struct CollidingPair {
  std::string first, second;
  double depth = 0;  ///< m
};

struct CollisionOptions {
  double allowed_depth = 0.001;  ///< m, overlap that does not count as a collision
  bool self = true;              ///< links of the hand may not overlap one another

  template <class Visitor>
  void visit(Visitor&& v) {
    v("allowed_depth", allowed_depth, 0.0, 0.02, "m, overlap that does not count as a collision");
    v("self", self, "check collisions between links of the hand, too");
  }
};

/// Asks whether the hand, a table at height 0, fixtures on it and at most one object overlap. It is
/// built from what is believed of them, never from the simulated or the real world.
///
/// Queries may write into buffers: each thread needs a checker of its own.
class CollisionChecker {
 public:
  virtual ~CollisionChecker() = default;

  /// The hand that is asked about.
  [[nodiscard]] virtual const hand::Description& hand() const = 0;

  /// Puts the object at rest into the world. @throws BadInput for a checker without object
  virtual void place(const Eigen::Isometry3d& T_world_object) = 0;

  /// Fixes the object to the palm. The hand may touch it then, it may not touch table or fixture.
  /// @throws BadInput for a checker without object
  virtual void hold(const Eigen::Isometry3d& T_palm_object) = 0;

  /// T_world_palm of the hand. @param joints  rad
  [[nodiscard]] virtual Eigen::Isometry3d palm_pose(const hand::MountPosition& mount,
                                                    const hand::JointVector& joints) = 0;

  /// The pair of bodies that overlap deepest beyond the allowed depth; none if the hand (and what
  /// it holds) is free. @param joints  rad
  [[nodiscard]] virtual std::optional<CollidingPair> deepest_collision(
      const hand::MountPosition& mount, const hand::JointVector& joints) = 0;
};

}  // namespace palpate::planning
