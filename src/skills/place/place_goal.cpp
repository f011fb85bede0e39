// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/place_goal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "palpate/core/angle.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/nearest_mount.hpp"

namespace palpate::skills {
namespace {

constexpr double kSettles = 30 * std::numbers::pi / 180;        // rad: more than a grasp tilts
constexpr double kSameStablePose = 3 * std::numbers::pi / 180;  // rad
constexpr double kFullTurn = 2 * std::numbers::pi;              // rad

std::string obstacle_at(const hand::MountPosition& mount, const GoalOptions& options) {
  if (mount.xyz.head<2>().cwiseAbs().maxCoeff() > options.reach) {
    return fmt::format("the mount would be at ({:.2f}, {:.2f}) m, out of reach", mount.xyz.x(),
                       mount.xyz.y());
  }
  if (mount.xyz.z() > options.highest) {
    return fmt::format("the mount would be {:.2f} m high, out of reach", mount.xyz.z());
  }
  return {};
}

hand::MountPosition raised(hand::MountPosition mount, double by) {
  mount.xyz.z() += by;
  return mount;
}

/// m by which the object hangs lower in the hand than the goal counts on.
double sunk_in_hand(const geometry::KnownObject& object, const HeldObject& held,
                    const PlaceGoal& goal) {
  constexpr double kMost = 0.015;  // m: more is an error of the estimate
  const Eigen::Isometry3d T_world_mount = goal.mount.pose();
  const auto lowest = [&](const Eigen::Isometry3d& T_mount_object) {
    return geometry::lowest_point(T_world_mount * T_mount_object, object.mesh);
  };
  return std::clamp(lowest(goal.T_mount_object) - lowest(held.T_mount_object), 0.0, kMost);
}

double turn_between(const hand::MountPosition& a, const hand::MountPosition& b) {
  return (a.ypr - b.ypr).norm();
}

/// One goal for each symmetry of the object, that with the least turn of the mount first.
std::vector<PlaceGoal> equal_goals(const geometry::KnownObject& object,
                                   const Eigen::Isometry3d& T_mount_object,
                                   const Eigen::Isometry3d& T_world_target,
                                   const hand::MountPosition& now, double rise) {
  std::vector<PlaceGoal> goals;
  for (const auto& S : object.symmetries) {
    PlaceGoal goal;
    goal.T_mount_object = T_mount_object;
    goal.T_world_object = T_world_target;
    goal.T_world_object.linear() = T_world_target.linear() * S;
    goal.mount = hand::nearest_mount(goal.T_world_object * T_mount_object.inverse(), now);
    goal.above = raised(goal.mount, rise);
    goals.push_back(goal);
  }
  std::stable_sort(goals.begin(), goals.end(), [&](const PlaceGoal& a, const PlaceGoal& b) {
    return turn_between(a.mount, now) < turn_between(b.mount, now);
  });
  return goals;
}

/// The same goal, and those with a full turn more or less of the mount.
std::array<PlaceGoal, 3> either_way_round(const PlaceGoal& goal) {
  std::array<PlaceGoal, 3> goals = {goal, goal, goal};
  for (const auto& [i, turn] : {std::pair(1, kFullTurn), std::pair(2, -kFullTurn)}) {
    goals[i].mount.ypr.x() += turn;
    goals[i].above.ypr.x() += turn;
  }
  return goals;
}

/// The goal to which the arm can bring the hand.
std::optional<PlaceGoal> within_reach(const PlaceGoal& goal, const GoalObstacle& arm_obstacle,
                                      std::string& obstacle) {
  if (!arm_obstacle) return goal;
  for (const PlaceGoal& way_round : either_way_round(goal)) {
    const std::string found = arm_obstacle(way_round);
    if (found.empty()) return way_round;
    if (obstacle.empty()) obstacle = found;
  }
  return std::nullopt;
}

/// Why the hand cannot come down there with these joints; empty: it can.
std::string obstacle_to(const PlaceGoal& goal, const hand::JointVector& joints,
                        planning::CollisionChecker& scene, const GoalOptions& options) {
  if (std::string obstacle = obstacle_at(goal.above, options); !obstacle.empty()) return obstacle;
  for (const auto& mount : {raised(goal.mount, options.room), goal.above}) {
    const auto pair = scene.deepest_collision(mount, joints);
    if (!pair) continue;
    return fmt::format("{} would be {:.0f} mm inside {}", pair->first, 1e3 * pair->depth,
                       pair->second);
  }
  return {};
}

}  // namespace

std::optional<HeldObject> held_object(const geometry::KnownObject& object,
                                      const localization::Posterior& posterior,
                                      const estimation::EventLog& log,
                                      std::optional<std::size_t> at,
                                      const localization::SamePose& same, bool turned) {
  const auto closed = log.at(estimation::TouchEvent::closed);
  if (posterior.modes.empty() || !closed || !at) return std::nullopt;
  const Eigen::Isometry3d T_world_closed = log.readings[*closed].mount.pose();
  const Eigen::Isometry3d T_mount_world = log.readings[*at].mount.pose().inverse();

  std::map<std::size_t, double> stable_poses;
  std::vector<localization::WeightedPose> in_air, flat;
  for (const localization::WeightedPose& pose : localization::poses_of(posterior)) {
    const Eigen::Isometry3d T_mount_object = T_mount_world * pose.T;
    const Eigen::Isometry3d standing = T_world_closed * T_mount_object;
    const bool settles = !turned && nearest_stable_pose(object, standing.linear()).tilt < kSettles;
    in_air.push_back({T_mount_object, pose.weight});
    flat.push_back({T_world_closed.inverse() * (settles ? laid_flat(object, standing) : standing),
                    pose.weight});
  }
  const localization::PoseConsensus best = localization::consensus(flat, object.symmetries, same);
  HeldObject held;
  held.T_mount_object_flat = best.T;
  held.T_mount_object = localization::consensus(in_air, object.symmetries, same).T;
  held.found_stable_pose =
      nearest_stable_pose(object, (T_world_closed * best.T).linear()).stable_pose;
  held.certainty = best.share * (1 - posterior.residual_mass());
  return held;
}

GoalSearch find_goal(const geometry::KnownObject& object, const HeldObject& held,
                     const Eigen::Isometry3d& T_world_target, const hand::HandReading& now,
                     planning::CollisionChecker& scene, const GoalOptions& options,
                     const GoalObstacle& arm_obstacle) {
  GoalSearch search;
  search.same_stable_pose =
      same_side_up(object, T_world_target.linear(),
                   object.stable_poses[held.found_stable_pose].R_table_object, kSameStablePose);
  const Eigen::Isometry3d& T_mount_object =
      search.same_stable_pose ? held.T_mount_object_flat : held.T_mount_object;
  const hand::JointVector joints = plannable(scene.hand(), now.joints);
  scene.hold(scene.palm_pose(hand::MountPosition{}, joints).inverse() * T_mount_object);
  for (const PlaceGoal& goal :
       equal_goals(object, T_mount_object, T_world_target, now.mount, options.rise)) {
    std::string obstacle = obstacle_to(goal, joints, scene, options);
    if (obstacle.empty()) search.goal = within_reach(goal, arm_obstacle, obstacle);
    if (search.goal) {
      search.goal->sunk = sunk_in_hand(object, held, goal);
      return search;
    }
    if (search.obstacle.empty()) search.obstacle = obstacle;
  }
  return search;
}

hand::JointVector plannable(const hand::Description& hand, const hand::JointVector& joints) {
  hand::JointVector clamped = joints;
  for (int i = 0; i < hand.joint_count(); ++i) {
    const hand::Range range = hand.joints[static_cast<std::size_t>(i)].range;
    clamped[i] = std::clamp(clamped[i], range.low, range.high);
  }
  return hand::joints_in_free_flexion(hand, hand::actuator_positions(hand, clamped));
}

}  // namespace palpate::skills
