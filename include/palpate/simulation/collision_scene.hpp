// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "palpate/geometry/known_object.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/simulation/fixture.hpp"

namespace palpate::simulation {

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
    v("allowed_depth", allowed_depth, 0.0, 0.02, "m, overlap that is no collision");
    v("self", self, "links of the hand may not overlap one another");
  }
};

/// The hand, the table at height 0, what stands fast on it and at most one object, asked only
/// whether they overlap. It is
/// built from what is known of the object: its mesh and an estimated pose, never the true one.
///
/// Queries write into buffers of the scene: each thread needs a scene of its own.
class CollisionScene {
 public:
  /// Hand and table alone. @throws BadInput if the hand's model cannot be used
  explicit CollisionScene(const CollisionOptions& options = {});
  /// With the object and the fixture, the object far away until it is placed. @throws BadInput also
  /// for an unusable mesh
  explicit CollisionScene(const geometry::KnownObject& object, const CollisionOptions& options = {},
                          const Fixture& fixture = {});
  ~CollisionScene();
  CollisionScene(CollisionScene&&) noexcept;
  CollisionScene& operator=(CollisionScene&&) noexcept;

  /// Puts the object at rest into the world. @throws BadInput for a scene without object
  void place(const Eigen::Isometry3d& T_world_object);

  /// Fixes the object to the palm. The hand may touch it then, it may not touch table or
  /// fixture.
  /// @throws BadInput for a scene without object
  void hold(const Eigen::Isometry3d& T_palm_object);

  /// T_world_palm of the hand. @param joints  rad
  [[nodiscard]] Eigen::Isometry3d palm_pose(const hand::BasePosition& base,
                                            const hand::JointVector& joints);

  /// The pair of bodies that overlap deepest beyond the allowed depth; none if the hand (and what
  /// it holds) is free. @param joints  rad
  [[nodiscard]] std::optional<CollidingPair> deepest_collision(const hand::BasePosition& base,
                                                               const hand::JointVector& joints);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::simulation
