// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/planning/collision_checker.hpp"
#include "palpate/planning/fixture.hpp"

namespace palpate::simulation {

/// The collision checker in MuJoCo.
class CollisionScene final : public planning::CollisionChecker {
 public:
  /// Hand and table alone. @throws BadInput if the hand's model cannot be used
  /// @param believed  its links are where they are believed to be, not where its drawing has them
  explicit CollisionScene(const hand::Description& believed,
                          const planning::CollisionOptions& options = {});
  /// With the object and the fixture, the object far away until it is placed. @throws BadInput also
  /// for an unusable mesh
  CollisionScene(const geometry::KnownObject& object, const hand::Description& believed,
                 const planning::CollisionOptions& options = {},
                 const planning::Fixture& fixture = {});
  ~CollisionScene() override;
  [[nodiscard]] const hand::Description& hand() const override;
  CollisionScene(CollisionScene&&) noexcept;
  CollisionScene& operator=(CollisionScene&&) noexcept;

  void place(const Eigen::Isometry3d& T_world_object) override;
  void hold(const Eigen::Isometry3d& T_palm_object) override;
  [[nodiscard]] Eigen::Isometry3d palm_pose(const hand::MountPosition& mount,
                                            const hand::JointVector& joints) override;
  [[nodiscard]] std::optional<planning::CollidingPair> deepest_collision(
      const hand::MountPosition& mount, const hand::JointVector& joints) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::simulation
