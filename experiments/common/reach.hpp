// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/simulation/collision/collision_scene.hpp"
#include "pointing_finger.hpp"

namespace palpate::experiment {

/// How the hand is held while a fingertip is led along an object.
struct Stand {
  PointingFinger finger;
  Eigen::Matrix3d R_world_mount;
  double free_share = 0;  ///< of the places that the tip reaches with nothing else touching
};

/// Where on an object that rests on the table a finger gets without the hand being in the way.
class Reach {
 public:
  Reach(const geometry::KnownObject& object, const Eigen::Isometry3d& T_world_object,
        hand::Description hand);

  /// The way to hold the hand, on the side of that azimuth (rad) from the object, in which the tip
  /// is free in most of the places of its centre (m, world).
  Stand best_stand(int finger, double azimuth, const std::vector<Eigen::Vector3d>& centers);

  /// Whether any finger gets to the place with its tip on any of the ways to hold the hand.
  bool any_finger_reaches(double azimuth, const Eigen::Vector3d& center);

 private:
  bool free(const PointingFinger& finger, const Eigen::Matrix3d& R_world_mount,
            const Eigen::Vector3d& center);

  simulation::CollisionScene scene_;
  hand::Description hand_;
};

}  // namespace palpate::experiment
