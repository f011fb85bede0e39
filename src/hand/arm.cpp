// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/arm.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::hand {
namespace {

constexpr double kSolved = 1e-5;   // m and rad
constexpr int kSteps = 60;         // of a search
constexpr double kFarthest = 0.3;  // m and rad of error that one step goes for
constexpr double kDamping = 1e-6, kDampingOfError = 1e-2;
constexpr int kStarts = 120;           // of the search for branches
constexpr double kSameBranch = 0.1;    // rad
constexpr double kTableMargin = 0.01;  // m
constexpr int kApart = 3;              // links between two that may meet
constexpr int kStanding = 2;           // joints from the stand, whose links stay above the table

using Error = Eigen::Matrix<double, 6, 1>;

ArmVector within_ranges(const ArmDescription& arm, ArmVector joints) {
  for (Eigen::Index i = 0; i < joints.size(); ++i) {
    const Range& range = arm.joints[static_cast<std::size_t>(i)].range;
    joints[i] = std::clamp(joints[i], range.low, range.high);
  }
  return joints;
}

/// [w; v] from one pose to another, in the world's axes.
Error error_between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  Error error;
  error << log_so3(to.linear() * from.linear().transpose()), to.translation() - from.translation();
  return error;
}

/// The step of damped least squares. Near a solution it is Newton's.
ArmVector step_to(const ArmJacobian& J, Error error) {
  const double size = error.norm();
  if (size > kFarthest) error *= kFarthest / size;
  Matrix6d normal = J * J.transpose();
  normal.diagonal().array() += kDamping + kDampingOfError * error.squaredNorm();
  return J.transpose() * normal.ldlt().solve(error);
}

/// Links of joints, counted from the stand.
int depth_of(const ArmDescription& arm, int link) {
  int depth = 0;
  for (; link >= 0; link = arm.links[static_cast<std::size_t>(link)].parent) {
    depth += arm.links[static_cast<std::size_t>(link)].joint >= 0;
  }
  return depth;
}

struct PlacedBall {
  Eigen::Vector3d center;  // in the world
  double radius;
  int depth;  // joints from the stand
  std::string link;
};

std::vector<PlacedBall> balls_of(const ArmDescription& arm, const ArmVector& joints) {
  const auto poses = link_poses(arm, joints);
  std::vector<PlacedBall> balls;
  for (const LinkSphere& ball : arm.spheres) {
    const auto link = static_cast<std::size_t>(ball.link);
    balls.push_back(
        {poses[link] * ball.center, ball.radius, depth_of(arm, ball.link), arm.links[link].name});
  }
  const Eigen::Isometry3d T_world_mount =
      poses[static_cast<std::size_t>(arm.flange)] * arm.T_flange_mount;
  for (const LinkSphere& ball : arm.carried) {
    balls.push_back(
        {T_world_mount * ball.center, ball.radius, depth_of(arm, arm.flange), "the hand"});
  }
  return balls;
}

/// The same angles less whole turns, where the ranges allow that.
ArmVector unwound(const ArmDescription& arm, const ArmVector& joints) {
  ArmVector result = joints;
  for (double& q : result) q = std::remainder(q, 2 * std::numbers::pi);
  return within_ranges(arm, result) == result ? result : joints;
}

}  // namespace

std::vector<Eigen::Isometry3d> link_poses(const ArmDescription& arm, const ArmVector& joints) {
  std::vector<Eigen::Isometry3d> poses;
  poses.reserve(arm.links.size());
  for (const Link& link : arm.links) {
    Eigen::Isometry3d T =
        (link.parent < 0 ? arm.T_world_stand : poses[static_cast<std::size_t>(link.parent)]) *
        link.T_parent_link;
    if (link.joint >= 0) T.rotate(Eigen::AngleAxisd(joints[link.joint], link.axis));
    poses.push_back(T);
  }
  return poses;
}

Eigen::Isometry3d mount_pose(const ArmDescription& arm, const ArmVector& joints) {
  return link_poses(arm, joints)[static_cast<std::size_t>(arm.flange)] * arm.T_flange_mount;
}

ArmJacobian mount_jacobian(const ArmDescription& arm, const ArmVector& joints) {
  const auto poses = link_poses(arm, joints);
  const Eigen::Vector3d p =
      (poses[static_cast<std::size_t>(arm.flange)] * arm.T_flange_mount).translation();
  ArmJacobian J = ArmJacobian::Zero(6, arm.joint_count());
  for (int i = arm.flange; i >= 0; i = arm.links[static_cast<std::size_t>(i)].parent) {
    const Link& link = arm.links[static_cast<std::size_t>(i)];
    if (link.joint < 0) continue;
    const Eigen::Isometry3d& T = poses[static_cast<std::size_t>(i)];
    const Eigen::Vector3d axis = T.linear() * link.axis;
    J.col(link.joint).head<3>() = axis;
    J.col(link.joint).tail<3>() = axis.cross(p - T.translation());
  }
  return J;
}

std::optional<ArmVector> inverse_kinematics(const ArmDescription& arm,
                                            const Eigen::Isometry3d& T_world_mount,
                                            const ArmVector& near) {
  ArmVector joints = within_ranges(arm, near);
  for (int i = 0; i < kSteps; ++i) {
    const Error error = error_between(mount_pose(arm, joints), T_world_mount);
    if (error.norm() < kSolved) return joints;
    joints = within_ranges(arm, joints + step_to(mount_jacobian(arm, joints), error));
  }
  return std::nullopt;
}

std::vector<ArmVector> inverse_kinematics_branches(const ArmDescription& arm,
                                                   const Eigen::Isometry3d& T_world_mount) {
  RandomStream random(0, "branches of an arm");
  std::vector<ArmVector> branches;
  for (int i = 0; i < kStarts; ++i) {
    ArmVector start(arm.joint_count());
    for (Eigen::Index k = 0; k < start.size(); ++k) {
      const Range& range = arm.joints[static_cast<std::size_t>(k)].range;
      start[k] = random.uniform(std::max(range.low, -std::numbers::pi),
                                std::min(range.high, std::numbers::pi));
    }
    const auto found = inverse_kinematics(arm, T_world_mount, start);
    if (!found) continue;
    const ArmVector joints = unwound(arm, *found);
    const bool known = std::ranges::any_of(branches, [&](const ArmVector& one) {
      return (one - joints).cwiseAbs().maxCoeff() < kSameBranch;
    });
    if (!known) branches.push_back(joints);
  }
  return branches;
}

std::string arm_collision(const ArmDescription& arm, const ArmVector& joints) {
  const auto balls = balls_of(arm, joints);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const PlacedBall& one = balls[i];
    const bool of_hand = i >= arm.spheres.size();
    if (!of_hand && one.depth > kStanding && one.center.z() - one.radius < kTableMargin) {
      return fmt::format("{} would meet the table", one.link);
    }
    for (std::size_t k = 0; k < i; ++k) {
      const PlacedBall& other = balls[k];
      if (std::abs(one.depth - other.depth) < kApart) continue;
      if ((one.center - other.center).norm() > one.radius + other.radius) continue;
      return fmt::format("{} would meet {}", one.link, other.link);
    }
  }
  return {};
}

}  // namespace palpate::hand
