// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/arm_follower.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "palpate/core/error.hpp"

namespace palpate::hand {
namespace {

constexpr double kLargestStretch = 10;  // beyond it a way passes a singularity
constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kFreedoms = 6;  // of the mount

/// Of the tour, m: heights of the mount and how far it is from the middle.
constexpr double kHigh = 0.3, kLow = 0.12, kAside = 0.1;
constexpr double kTourStep = 0.05;  // rad

std::string place_text(const MountPosition& mount) {
  return fmt::format(
      "with the mount at ({:.3f}, {:.3f}, {:.3f}) m, yaw {:.0f} deg, pitch {:.0f}, "
      "roll {:.0f}",
      mount.xyz.x(), mount.xyz.y(), mount.xyz.z(), mount.ypr[0] * 360 / kTurn,
      mount.ypr[1] * 360 / kTurn, mount.ypr[2] * 360 / kTurn);
}

/// Times as long as a tick that a step of the joints takes at full speed.
double ticks_of(const ArmDescription& arm, const ArmVector& step) {
  double ticks = 0;
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    const double fastest = arm.joints[static_cast<std::size_t>(i)].max_speed * kTick;
    ticks = std::max(ticks, std::abs(step[i]) / fastest);
  }
  return ticks;
}

/// The speed of a joint in the next tick with which it comes to a target, and comes to move as the
/// target does, without passing it: within the joint's speed and acceleration.
/// @param error  rad, from the joint to where the target will be
double speed_towards(const ArmJoint& joint, double error, double target_speed, double speed) {
  const double gain = joint.max_acceleration * kTick;
  const double distance = std::abs(error - target_speed * kTick);
  // The fastest approach that can still be braked within the distance, in whole ticks.
  const double braking =
      std::sqrt(gain * gain / 4 + 2 * joint.max_acceleration * distance) - gain / 2;
  const double approach = std::min(distance / kTick, braking);
  const double wish = target_speed + std::copysign(approach, error - target_speed * kTick);
  const double limited = std::clamp(wish, speed - gain, speed + gain);
  return std::clamp(limited, -joint.max_speed, joint.max_speed);
}

/// Times as long as wanted that a way of the joints must take, from one tick to the next.
class Stretch {
 public:
  explicit Stretch(const ArmDescription& arm)
      : arm_(arm), last_(ArmVector::Zero(arm.joint_count())) {}

  double of(const ArmVector& step) {
    double times = ticks_of(arm_, step);
    for (Eigen::Index i = 0; i < step.size(); ++i) {
      const double largest =
          arm_.joints[static_cast<std::size_t>(i)].max_acceleration * kTick * kTick;
      times = std::max(times, std::sqrt(std::abs(step[i] - last_[i]) / largest));
    }
    last_ = step;
    return times;
  }

 private:
  const ArmDescription& arm_;
  ArmVector last_;
};

/// Why no branch of the inverse kinematics can be taken.
std::string why_not(const ArmDescription& arm, std::size_t branches, const std::string& collides) {
  if (branches > 0) return fmt::format("{} in each of {} solutions found", collides, branches);
  if (arm.joint_count() >= kFreedoms) return "the inverse kinematics has no solution";
  return fmt::format("the inverse kinematics has no solution, and {} joints are fewer than {}",
                     arm.joint_count(), kFreedoms);
}

void append_line(std::vector<MountPosition>& way, const MountPosition& to) {
  const MountPosition from = way.back();
  const double turn = (to.ypr - from.ypr).cwiseAbs().maxCoeff();
  const double slide = (to.xyz - from.xyz).norm() / 0.2;
  const int steps = 1 + static_cast<int>(std::max(turn, slide) / kTourStep);
  for (int i = 1; i <= steps; ++i) {
    way.push_back(between(from, to, static_cast<double>(i) / steps));
  }
}

}  // namespace

const ArmVector& ArmFollower::reset(const Eigen::Isometry3d& T_world_mount,
                                    std::span<const MountPosition> tour) {
  std::size_t most = 0;
  bool any = false;
  std::string collides;  // in the first branch that does
  const std::vector<ArmVector> branches = inverse_kinematics_branches(arm_, T_world_mount);
  for (const ArmVector& branch : branches) {
    const std::string meets = arm_collision(arm_, branch);
    if (collides.empty()) collides = meets;
    if (!meets.empty()) continue;
    const std::size_t length = followed(branch, tour);
    if (any && length <= most) continue;
    any = true, most = length, joints_ = branch;
  }
  if (!any) {
    throw BadInput(fmt::format("the arm {} cannot hold the hand {}: {}", arm_.name,
                               place_text(MountPosition::at(T_world_mount)),
                               why_not(arm_, branches.size(), collides)));
  }
  wanted_ = joints_;
  speeds_.setZero(joints_.size());
  return joints_;
}

/// How many positions of a tour can be taken, one after the other; those that cannot are left out.
std::size_t ArmFollower::followed(ArmVector joints, std::span<const MountPosition> tour) const {
  std::size_t count = 0;
  for (const MountPosition& mount : tour) {
    const auto next = inverse_kinematics(arm_, mount.pose(), joints);
    if (!next || ticks_of(arm_, *next - joints) > kLargestStretch) continue;
    joints = *next;
    if (arm_collision(arm_, joints).empty()) ++count;
  }
  return count;
}

void ArmFollower::require_reset() const {
  if (joints_.size() > 0 && joints_.size() == arm_.joint_count()) return;
  throw std::logic_error("an ArmFollower's reset() has to be called first");
}

const ArmVector& ArmFollower::follow(const Eigen::Isometry3d& T_world_mount) {
  require_reset();
  ArmVector wanted = wanted_;
  if (const auto found = inverse_kinematics(arm_, T_world_mount, joints_)) wanted = *found;
  for (Eigen::Index i = 0; i < joints_.size(); ++i) {
    const double target_speed = (wanted[i] - wanted_[i]) / kTick;
    speeds_[i] = speed_towards(arm_.joints[static_cast<std::size_t>(i)], wanted[i] - joints_[i],
                               target_speed, speeds_[i]);
    joints_[i] += kTick * speeds_[i];
  }
  wanted_ = wanted;
  return joints_;
}

PathFeasibility ArmFollower::check_path(std::span<const MountPosition> way) const {
  require_reset();
  PathFeasibility result;
  ArmVector joints = wanted_;
  Stretch stretch(arm_);
  std::string collides = arm_collision(arm_, joints);  // before it moves: may be left
  for (const MountPosition& mount : way) {
    const auto next = inverse_kinematics(arm_, mount.pose(), joints);
    if (!next) {
      result.obstacle = fmt::format("out of reach of the arm {}", place_text(mount));
      return result;
    }
    const ArmVector step = *next - joints;
    if (ticks_of(arm_, step) > kLargestStretch) {
      result.obstacle = fmt::format("the arm is singular {}", place_text(mount));
      return result;
    }
    joints = *next;
    const std::string meets = arm_collision(arm_, joints);
    if (meets.empty()) collides.clear();
    if (meets != collides) {
      result.obstacle = fmt::format("{} {}", meets, place_text(mount));
      return result;
    }
    result.stretch = std::max(result.stretch, stretch.of(step));
    ++result.feasible;
  }
  return result;
}

std::vector<MountPosition> working_tour(const Description& hand) {
  const Postures& postures = hand.postures;
  std::vector<Attitude> attitudes = {postures.flat.attitude};
  for (const Preshape* preshape : {&postures.top, &postures.side}) {
    attitudes.insert(attitudes.end(), preshape->attitudes.begin(), preshape->attitudes.end());
  }
  for (const PointingHand& pointing : postures.pointing) attitudes.push_back(pointing.attitude);
  std::vector<MountPosition> way = {{{0, 0, kHigh}, {0, 0, 0}}};
  for (const Attitude& attitude : attitudes) {
    for (const double third : {0.0, 1.0, 2.0, 3.0}) {
      const Eigen::Vector3d ypr(third * kTurn / 4, attitude.pitch, attitude.roll);
      const Eigen::Vector3d aside =
          kAside * Eigen::Vector3d(-std::cos(ypr[0]), -std::sin(ypr[0]), 0);
      append_line(way, {{0, 0, kHigh}, ypr});
      append_line(way, {aside + Eigen::Vector3d(0, 0, kLow), ypr});
      append_line(way, {{0, 0, kHigh}, ypr});
    }
    append_line(way, {{0, 0, kHigh}, {0, attitude.pitch, attitude.roll}});
  }
  return way;
}

}  // namespace palpate::hand
