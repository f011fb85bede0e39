// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/arm_planner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/hand/nearest_mount.hpp"
#include "planning/search.hpp"

namespace palpate::planning {
namespace {

constexpr double kLever = 0.3;         // m of path, a radian of an arm's joint
constexpr double kLargestStep = 0.3;   // rad of a joint, between two positions of a line
constexpr double kSamePosture = 1e-9;  // m of path: no motion, but rounding
constexpr int kTimings = 3;            // till the mount keeps within its limits, too

/// Poses of the mount in the world of the plan, and postures of the arm.
class Carried {
 public:
  explicit Carried(const ArmStart& start)
      : arm_(*start.posture.arm),
        joints_(Eigen::Map<const Eigen::VectorXd>(
            start.posture.joints.data(), static_cast<Eigen::Index>(start.posture.joints.size()))),
        up_(Eigen::Translation3d(0, 0, start.table_height)),
        T_flange_mount_(hand::mount_pose(arm_, joints_).inverse() * up_ * start.mount.pose()) {}

  [[nodiscard]] const hand::ArmDescription& arm() const { return arm_; }
  [[nodiscard]] const hand::ArmVector& joints() const { return joints_; }

  [[nodiscard]] Eigen::Isometry3d pose(const hand::ArmVector& joints) const {
    return up_.inverse() * hand::mount_pose(arm_, joints) * T_flange_mount_;
  }
  /// By the arm's own kinematics, in its world.
  [[nodiscard]] Eigen::Isometry3d arm_pose(const hand::MountPosition& mount) const {
    return up_ * mount.pose() * T_flange_mount_.inverse();
  }

 private:
  const hand::ArmDescription& arm_;
  hand::ArmVector joints_;
  Eigen::Isometry3d up_;              // from the plan's world to the arm's
  Eigen::Isometry3d T_flange_mount_;  // what the arm's kinematics lack
};

/// What an arm may do that carries a hand.
class ArmSpace : public FreeSpace {
 public:
  ArmSpace(const Carried& carried, const hand::JointVector& joints, CollisionChecker& scene,
           double step)
      : FreeSpace(Coordinates::Constant(carried.joints().size(), kLever), step),
        carried_(carried),
        joints_(joints),
        scene_(scene) {}

 private:
  bool is_free(const Coordinates& configuration) override {
    const hand::ArmVector joints = configuration;
    return hand::arm_collision(carried_.arm(), joints).empty() &&
           !scene_.deepest_collision(hand::MountPosition::at(carried_.pose(joints)), joints_);
  }

  const Carried& carried_;
  const hand::JointVector& joints_;
  CollisionChecker& scene_;
};

Carried carried_of(const ArmStart& start) {
  const hand::ArmDescription* arm = start.posture.arm;
  if (!arm || std::ssize(start.posture.joints) != arm->joint_count()) {
    throw BadInput(fmt::format("an arm's posture of {} joints where the arm has {}",
                               start.posture.joints.size(), arm ? arm->joint_count() : 0));
  }
  return Carried(start);
}

/// Why the arm cannot go on along a line from there.
std::string obstacle_along(const Carried& carried, hand::ArmVector joints,
                           std::span<const hand::MountPosition> line) {
  for (const hand::MountPosition& mount : line) {
    const auto next = hand::inverse_kinematics(carried.arm(), carried.arm_pose(mount), joints);
    if (!next || (*next - joints).cwiseAbs().maxCoeff() > kLargestStep) {
      return fmt::format("the arm {} cannot follow the way at its end", carried.arm().name);
    }
    joints = *next;
    if (std::string meets = hand::arm_collision(carried.arm(), joints); !meets.empty()) {
      return meets;
    }
  }
  return {};
}

struct ArmGoal {
  std::optional<hand::ArmVector> joints;
  std::string obstacle;  ///< where there are none
};

/// The posture at the start of a line that is nearest to that now, of those from which the line can
/// be followed.
ArmGoal goal_of(const Carried& carried, std::span<const hand::MountPosition> line) {
  if (line.empty()) throw BadInput("a line of no positions for an arm");
  auto branches = hand::inverse_kinematics_branches(carried.arm(), carried.arm_pose(line.front()));
  const auto farther = [&](const hand::ArmVector& joints) {
    return (joints - carried.joints()).cwiseAbs().maxCoeff();
  };
  std::ranges::stable_sort(branches, {}, farther);
  ArmGoal goal{std::nullopt, fmt::format("out of reach of the arm {}", carried.arm().name)};
  for (std::size_t i = 0; i < branches.size(); ++i) {
    const std::string obstacle = obstacle_along(carried, branches[i], line);
    if (obstacle.empty()) return {branches[i], {}};
    if (i == 0) goal.obstacle = obstacle;
  }
  return goal;
}

SearchSpace space_of(const hand::ArmDescription& arm) {
  const auto count = arm.joint_count();
  SearchSpace space{std::vector<int>(static_cast<std::size_t>(count)), Coordinates(count),
                    Coordinates(count)};
  std::iota(space.moving.begin(), space.moving.end(), 0);
  for (Eigen::Index i = 0; i < count; ++i) {
    const hand::Range& range = arm.joints[static_cast<std::size_t>(i)].range;
    space.low[i] = range.low, space.high[i] = range.high;
  }
  return space;
}

CoordinateLimits limits_of(const hand::ArmDescription& arm) {
  CoordinateLimits limits{Coordinates(arm.joint_count()), Coordinates(arm.joint_count())};
  for (Eigen::Index i = 0; i < arm.joint_count(); ++i) {
    limits.speed[i] = arm.joints[static_cast<std::size_t>(i)].max_speed;
    limits.acceleration[i] = arm.joints[static_cast<std::size_t>(i)].max_acceleration;
  }
  return limits;
}

/// Times as long as the mount must take for a motion, one pose a tick.
double stretch_for(const std::vector<Eigen::Isometry3d>& poses, const MotionLimits& limits) {
  double times = 1;
  Eigen::Vector3d last_slide = Eigen::Vector3d::Zero(), last_turn = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Vector3d slide =
        (poses[i].translation() - poses[i - 1].translation()) / hand::kTick;
    const Eigen::Vector3d turn =
        log_so3(poses[i].linear() * poses[i - 1].linear().transpose()) / hand::kTick;
    times = std::max({times, slide.norm() / limits.mount_speed, turn.norm() / limits.turn_speed});
    const double slide_change = (slide - last_slide).norm() / hand::kTick,
                 turn_change = (turn - last_turn).norm() / hand::kTick;
    times = std::max({times, std::sqrt(slide_change / limits.mount_acceleration),
                      std::sqrt(turn_change / limits.turn_acceleration)});
    last_slide = slide, last_turn = turn;
  }
  return times;
}

/// Poses of the mount along a way of the arm, one a tick, at rest in its corners.
std::vector<Eigen::Isometry3d> timed(const Carried& carried,
                                     const std::vector<Coordinates>& corners,
                                     const Coordinates& metric, const MotionLimits& mount_limits) {
  if (corners.size() < 2) return {carried.pose(carried.joints())};
  const auto path = rounded(corners, std::vector<double>(corners.size(), 0.0), metric);
  CoordinateLimits limits = limits_of(carried.arm());
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < kTimings; ++i) {
    poses.clear();
    for (const Coordinates& joints : time_path(path, limits, metric)) {
      poses.push_back(carried.pose(joints));
    }
    const double times = stretch_for(poses, mount_limits);
    if (times <= 1) break;
    limits.speed /= times;
    limits.acceleration /= times * times;
  }
  return poses;
}

/// A free way of the arm; empty if there is none.
std::vector<Coordinates> corners_to(const std::optional<hand::ArmVector>& goal,
                                    const Carried& carried, ArmSpace& space,
                                    const PlanOptions& options, std::uint64_t seed) {
  if (!goal) return {};
  const Coordinates from = carried.joints(), to = *goal;
  if (distance(from, to, space.metric()) <= kSamePosture) return {from};
  if (space.holds_line(from, to)) return {from, to};
  auto corners =
      search(from, to, space, space_of(carried.arm()),
             {planner_named(options.planner), options.iterations, options.shortenings}, seed);
  if (!corners.empty()) corners.front() = from, corners.back() = to;
  return corners;
}

/// Each pose with the angles that are nearest to those before.
std::vector<hand::HandCommand> commands_along(const std::vector<Eigen::Isometry3d>& poses,
                                              hand::MountPosition mount,
                                              const hand::JointVector& joints,
                                              const hand::Description& hand) {
  std::vector<hand::HandCommand> commands;
  for (const Eigen::Isometry3d& pose : poses) {
    mount = hand::nearest_mount(pose, mount);
    commands.push_back(command_of(Waypoint{mount, joints}, hand));
  }
  return commands;
}

}  // namespace

std::string arm_obstacle(const ArmStart& start, std::span<const hand::MountPosition> line) {
  return goal_of(carried_of(start), line).obstacle;
}

Plan plan_with_arm(const ArmStart& start, std::span<const hand::MountPosition> line,
                   const hand::JointVector& joints, CollisionChecker& scene,
                   const PlanOptions& options, std::uint64_t seed) {
  const auto began = std::chrono::steady_clock::now();
  const Carried carried = carried_of(start);
  ArmSpace space(carried, joints, scene, options.step);
  const std::vector<Coordinates> corners =
      corners_to(goal_of(carried, line).joints, carried, space, options, seed);
  Plan plan;
  if (corners.empty()) {
    plan.status = PlanStatus::no_path;
    plan.unreachable = 1;
  } else {
    std::vector<Eigen::Isometry3d> vertices;
    for (const Coordinates& corner : corners) vertices.push_back(carried.pose(corner));
    plan.corners = commands_along(vertices, start.mount, joints, scene.hand());
    plan.samples = commands_along(timed(carried, corners, space.metric(), options.limits),
                                  start.mount, joints, scene.hand());
    plan.arrivals = {0, plan.samples.size() - 1};
  }
  plan.checks = space.checks();
  plan.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return plan;
}

}  // namespace palpate::planning
