// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/place_goal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "palpate/core/angle.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/nearest_mount.hpp"

namespace palpate::skills {
namespace {

constexpr double kSettles = 30 * std::numbers::pi / 180;        // rad: more than a grasp tilts
constexpr double kSameStablePose = 3 * std::numbers::pi / 180;  // rad
constexpr double kAlike = 10 * std::numbers::pi / 180;          // rad
constexpr int kStepsDown = 20;
constexpr double kFullTurn = 2 * std::numbers::pi;  // rad

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

/// A goal and the symmetry of the object that it comes from.
struct EqualGoal {
  PlaceGoal goal;
  std::size_t symmetry = 0;
};

/// Goals for each symmetry of the object, that with the least turn of the mount first.
/// @param turns  of the mount in yaw by which they may differ, rad
std::vector<EqualGoal> equal_goals(const geometry::KnownObject& object,
                                   const Eigen::Isometry3d& T_mount_object,
                                   const Eigen::Isometry3d& T_world_target,
                                   const hand::MountPosition& now, double rise,
                                   const std::vector<double>& turns) {
  std::vector<EqualGoal> goals;
  for (std::size_t i = 0; i < object.symmetries.size(); ++i) {
    PlaceGoal goal;
    goal.T_mount_object = T_mount_object;
    goal.T_world_object = T_world_target;
    goal.T_world_object.linear() = T_world_target.linear() * object.symmetries[i];
    const hand::MountPosition mount =
        hand::nearest_mount(goal.T_world_object * T_mount_object.inverse(), now);
    for (const double turn : turns) {
      goal.mount = mount;
      goal.mount.ypr.x() += turn;
      goal.above = raised(goal.mount, rise);
      goals.push_back({goal, i});
    }
  }
  std::stable_sort(goals.begin(), goals.end(), [&](const EqualGoal& a, const EqualGoal& b) {
    return turn_between(a.goal.mount, now) < turn_between(b.goal.mount, now);
  });
  return goals;
}

/// Whether one of the positions differs by a small turn only: an arm can take neither or both.
bool any_alike(const std::vector<hand::MountPosition>& positions,
               const hand::MountPosition& mount) {
  return std::ranges::any_of(positions, [&](const hand::MountPosition& other) {
    return turn_between(other, mount) < kAlike;
  });
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
  const std::vector<double> turns =
      arm_obstacle ? std::vector<double>{0, kFullTurn, -kFullTurn} : std::vector<double>{0};
  std::vector<std::optional<std::string>> in_the_way(object.symmetries.size());
  std::vector<hand::MountPosition> out_of_reach;
  for (const auto& [goal, symmetry] :
       equal_goals(object, T_mount_object, T_world_target, now.mount, options.rise, turns)) {
    auto& obstacle = in_the_way[symmetry];
    if (!obstacle) obstacle = obstacle_to(goal, joints, scene, options);
    if (search.obstacle.empty()) search.obstacle = *obstacle;
    if (!obstacle->empty() || any_alike(out_of_reach, goal.mount)) continue;
    const std::string of_arm = arm_obstacle ? arm_obstacle(goal) : "";
    if (of_arm.empty()) {
      search.goal = goal;
      search.goal->sunk = sunk_in_hand(object, held, goal);
      search.out_of_reach = false;
      return search;
    }
    if (!search.out_of_reach) search.obstacle = of_arm;
    search.out_of_reach = true;
    out_of_reach.push_back(goal.mount);
  }
  return search;
}

std::vector<hand::MountPosition> path_down(const PlaceGoal& goal) {
  std::vector<hand::MountPosition> way;
  for (int i = 0; i <= kStepsDown; ++i) {
    way.push_back(between(goal.above, goal.mount, static_cast<double>(i) / kStepsDown));
  }
  return way;
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
