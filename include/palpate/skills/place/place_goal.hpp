// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpate/estimation/event_log.hpp"
#include "palpate/localization/consensus.hpp"
#include "palpate/planning/collision_checker.hpp"
#include "palpate/skills/place/place_target.hpp"
#include "palpate/skills/release/set_down_phase.hpp"

namespace palpate::skills {

/// How the object is held, as far as it matters to placing it.
struct HeldObject {
  Eigen::Isometry3d T_mount_object = Eigen::Isometry3d::Identity();  ///< in the air
  /// As it stood on the table in the closed hand, laid flat: lifting it let the fingers give way,
  /// setting it down takes that back.
  Eigen::Isometry3d T_mount_object_flat = Eigen::Isometry3d::Identity();
  std::size_t found_stable_pose = 0;  ///< in which it stood there
  double certainty = 0;               ///< share of the estimate that would be placed like this one
};

/// Makes one of the estimate's modes: those that come to the same when laid flat count together.
///
/// Height and tilt need no estimate, for the table fixed them when the fingers closed.
/// @param posterior  of the held object, in the world, at that reading
/// @param at  reading of the log where the object hangs in the hand
/// @param turned  by the fingers, since they closed, or fallen before: then the height and tilt
///        that the table fixed count no more
/// @return nothing without modes, without an instant, or where the hand has not closed
std::optional<HeldObject> held_object(const geometry::KnownObject& object,
                                      const localization::Posterior& posterior,
                                      const estimation::EventLog& log,
                                      std::optional<std::size_t> at,
                                      const localization::SamePose& same, bool turned = false);

struct GoalSearch {
  std::optional<PlaceGoal> goal;
  bool out_of_reach = false;  ///< what carries the hand cannot bring it to a goal that is free
  std::string obstacle;       ///< why there is none: what would collide, or be out of reach
  bool same_stable_pose =
      false;  ///< the target asks for the stable pose in which the object was found
};

struct GoalOptions {
  double rise = 0.10;    ///< m over the target from which the object is let down
  double room = 0.0015;  ///< m over the target where nothing may collide yet
  double reach = 0.9;    ///< m, of |x| and |y| of the mount
  double highest = 0.9;  ///< m, of the mount

  template <class Visitor>
  void visit(Visitor&& v) {
    v("rise", rise, 0.02, 0.4, "m, height above the target from which the object is lowered");
    v.expert("room", room, 0.0, 0.05,
             "m, height above the target down to which collisions are checked");
    v.expert("reach", reach, 0.1, 2.0, "m, largest |x| and |y| of the mount");
    v.expert("highest", highest, 0.1, 2.0, "m, largest height of the mount");
  }
};

/// Of the mount, from over a goal down to it.
std::vector<hand::MountPosition> path_down(const PlaceGoal& goal);

/// Why what carries the hand cannot bring it over a goal and down to it; empty: it can.
using GoalObstacle = std::function<std::string(const PlaceGoal&)>;

/// The mount position that brings the held object to the target: mount = T_world_object S
/// T_mount_object^-1, where S is that symmetry of the object that needs the least turn of the mount
/// and leaves hand and object free of table and fixture.
/// @param scene  with the object held in it
/// @param now  where the mount is; joints: of the closed hand, rad
/// @param arm_obstacle  of what carries the hand; where the least turn ends at a limit of its
///        joints, the mount turns farther, or the other way round
GoalSearch find_goal(const geometry::KnownObject& object, const HeldObject& held,
                     const Eigen::Isometry3d& T_world_target, const hand::HandReading& now,
                     planning::CollisionChecker& scene, const GoalOptions& options,
                     const GoalObstacle& arm_obstacle = {});

/// Joint angles as a planner takes them: within their ranges and coupling, without sensor noise
/// beyond them.
hand::JointVector plannable(const hand::Description& hand, const hand::JointVector& joints);

}  // namespace palpate::skills
