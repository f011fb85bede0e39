// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/planning/fixture.hpp"
#include "palpate/skills/resting_pose.hpp"

namespace palpate::skills {

/// A slot on the table: walls around the footprint of a stable pose, with room to all sides. Its
/// shape and place are known to all.
struct FixtureOptions {
  double x = 0.25, y = 0.15;  ///< m, where the object's centroid is to come
  double yaw = 0;             ///< rad, of the object seated in it
  int stable_pose = 0;        ///< of the object seated in it
  double tolerance = 0.005;   ///< m of room to every side; negative: too small
  double height = 0.006;      ///< m, of the walls
  double wall = 0.004;        ///< m, their thickness

  template <class Visitor>
  void visit(Visitor&& v) {
    v("x", x, -1.0, 1.0, "m, x of the seated object's centroid");
    v("y", y, -1.0, 1.0, "m, y of the seated object's centroid");
    v("yaw", yaw, -6.3, 6.3, "rad, yaw of the seated object");
    v("stable_pose", stable_pose, 0, 1000, "index of the seated object's stable pose");
    v("tolerance", tolerance, -0.1, 0.1, "m, clearance to every side");
    v("height", height, 0.002, 0.1, "m, height of the walls");
    v("wall", wall, 0.001, 0.05, "m, thickness of the walls");
  }
};

/// Where the object is to be put.
struct PlaceTarget {
  enum class Kind {
    pose,     ///< a pose in the world
    spot,     ///< at x, y with a yaw, standing as it is found standing
    fixture,  ///< into the slot
  };
  Kind kind = Kind::spot;
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();  ///< of pose and fixture
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();                      ///< of a spot, m
  double yaw = 0;                                                    ///< of a spot, rad
  bool on_the_way = false;  ///< to the target proper: the object will be picked up again there
};

/// A target from "fixture", "random" (a spot 10 to 25 cm from the origin and within reach, drawn by
/// the seed), "x,y,yaw" (m, rad) or the 16 numbers of a pose, row-major.
/// @param reach  m, how far from the origin a target may be
/// @throws BadInput for other text; for a target beyond the reach, inside the table, in the air, in
///         which the object does not rest, or for a fixture that is too small
PlaceTarget parse_target(std::string_view text, const geometry::KnownObject& object,
                         const FixtureOptions& fixture, double reach, std::uint64_t seed);

/// A pose in another stable pose than the object starts in, drawn by the seed: a stable pose by its
/// probability, at a random spot as above. Who sets the task knows how the object starts; the robot
/// is given the pose alone.
/// @param wanted  the stable pose of the target; -1: drawn
/// @param reach  m, how far from the origin the spot may be
/// @throws BadInput for a stable pose that the object does not have, where all are equal by
///         symmetry, or for a reach that is too small
PlaceTarget stable_pose_target(const geometry::KnownObject& object, std::size_t start_stable_pose,
                               int wanted, double reach, std::uint64_t seed);

/// Whether two stable poses, or a pose and a stable pose, are the same by the object's symmetry:
/// the same side is up, to `most` rad.
bool same_side_up(const geometry::KnownObject& object, const Eigen::Matrix3d& R_a,
                  const Eigen::Matrix3d& R_b, double most);

/// The walls of the slot: boxes along the sides of the footprint, which is the convex outline of
/// all of the object that is below the walls' top when it is seated.
/// @throws BadInput for a stable pose that the object does not have, or too little room
planning::Fixture make_fixture(const geometry::KnownObject& object, const FixtureOptions& options);

/// The stable pose whose up direction is nearest to that of a pose, and the angle between them.
struct NearestStablePose {
  std::size_t stable_pose = 0;
  double tilt = 0;  ///< rad
};
NearestStablePose nearest_stable_pose(const geometry::KnownObject& object,
                                      const Eigen::Matrix3d& R_world_object);

/// A pose laid flat: tilted the shortest way into the nearest stable pose, at the stable pose's
/// height over the table, centroid over the same place.
Eigen::Isometry3d laid_flat(const geometry::KnownObject& object,
                            const Eigen::Isometry3d& T_world_object);

/// Where a target is, for an object that was found in a stable pose; the same for stable poses that
/// are equal by symmetry.
Eigen::Isometry3d target_pose(const PlaceTarget& target, const geometry::KnownObject& object,
                              std::size_t found_stable_pose);

}  // namespace palpate::skills
