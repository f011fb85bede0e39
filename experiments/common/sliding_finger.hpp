// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "palpate/geometry/query/capsule_collider.hpp"
#include "palpate/recording/recording.hpp"
#include "palpate/simulation/world/world.hpp"
#include "pointing_finger.hpp"

namespace palpate::experiment {

/// Where the fingertip's centre is wanted at every tick, and the outward normal of the surface
/// below it; in the world, m.
struct TipPath {
  std::vector<Eigen::Vector3d> center, normal;
  Eigen::Matrix3d R_world_mount = pointing_down();  ///< of the hand, all along
};

/// One tick of a slide: what was sensed, and what the simulator knows of the contact.
struct SlideTick {
  recording::Frame frame;                     ///< with the truth
  std::vector<Eigen::Vector3d> true_normals;  ///< of the surface where the tip touches it, world
};

/// Slides a fingertip of the simulated hand along an object too heavy to move.
class SlidingFinger {
 public:
  /// @param finger  of the hand as it really is
  SlidingFinger(const geometry::KnownObject& object, const simulation::WorldOptions& options,
                std::uint64_t seed, PointingFinger finger);

  const hand::Description& believed_hand() const { return world_.hand_model(); }
  double tip_radius() const { return finger_.tip().radius; }

  /// Approaches the path's start along its normal and follows it, pressing with `force` (N): the
  /// depth follows the sensed force.
  std::vector<SlideTick> follow(const TipPath& path, const simulation::Start& start, double force);

 private:
  double pressing(const hand::HandReading& reading, const Eigen::Vector3d& n) const;
  SlideTick step(const hand::HandCommand& command);
  std::vector<Eigen::Vector3d> true_normals(const hand::HandReading& reading,
                                            const simulation::Truth& truth) const;

  geometry::MeshQuery mesh_;
  geometry::CapsuleCollider surface_;
  simulation::World world_;
  PointingFinger finger_;
};

/// One finger of the real hand, straight.
PointingFinger straight_finger(hand::FingerName finger);

/// An object of a mesh that rests as it stands in the mesh's frame and weighs so much that no
/// finger moves it.
geometry::KnownObject fixed_object(const std::string& name, geometry::TriangleMesh mesh);

}  // namespace palpate::experiment
