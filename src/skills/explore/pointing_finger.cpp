// SPDX-License-Identifier: Apache-2.0
#include "skills/explore/pointing_finger.hpp"

#include "skills/motion/lowest_part.hpp"

namespace palpate::skills {
namespace {

constexpr double kMoveSeconds = 2.0;       // s, about, of a guarded move with its travel
constexpr double kSecondsPerRadian = 0.4;  // s by which a turn of the hand delays its travel

/// Centre of the probing fingertip in the mount's frame, by the posture read.
Eigen::Vector3d probe_in_mount(const Executor& robot, const hand::PointingHand& pointing) {
  const auto T_mount_link = hand::forward_kinematics(robot.model(), robot.reading().joints);
  const hand::Finger& finger = robot.model().fingers[static_cast<std::size_t>(pointing.finger)];
  return T_mount_link[static_cast<std::size_t>(finger.link)] * finger.tip.b;
}

}  // namespace

hand::MountPosition mount_for_probe(const Executor& robot, const hand::PointingHand& pointing,
                                    double yaw, const Eigen::Vector3d& p) {
  hand::MountPosition mount;
  mount.ypr = {yaw, pointing.attitude.pitch, pointing.attitude.roll};
  mount.xyz = p - mount.pose().linear() * probe_in_mount(robot, pointing);
  return mount;
}

double tip_above_lowest(const Executor& robot, const hand::PointingHand& pointing) {
  const hand::Attitude attitude{pointing.attitude.pitch, pointing.attitude.roll};
  const double tip = -mount_for_probe(robot, pointing, 0, Eigen::Vector3d::Zero()).xyz.z();
  return tip - lowest_part(robot.model(), pointing.positions, attitude);
}

localization::ProbingFinger probing_finger(const Executor& robot,
                                           const hand::PointingHand& pointing, double yaw) {
  const auto& hand = robot.model();
  const auto T_mount_link = hand::forward_kinematics(hand, robot.reading().joints);
  const hand::MountPosition mount = mount_for_probe(robot, pointing, yaw, Eigen::Vector3d::Zero());
  const Eigen::Matrix3d R_world_mount = mount.pose().linear();
  const double turn = (mount.ypr - robot.command().mount.ypr).cwiseAbs().maxCoeff();
  const Eigen::Vector3d tip_center = probe_in_mount(robot, pointing);
  localization::ProbingFinger finger;
  finger.R_world_mount = R_world_mount;
  finger.seconds = kMoveSeconds + kSecondsPerRadian * turn;
  for (const auto& sphere : hand.spheres) {
    const Eigen::Vector3d p = T_mount_link[static_cast<std::size_t>(sphere.link)] * sphere.center;
    const bool tip = sphere.link == hand.fingers[static_cast<std::size_t>(pointing.finger)].link;
    (tip ? finger.tip : finger.rest).push_back({R_world_mount * (p - tip_center), sphere.radius});
  }
  return finger;
}

}  // namespace palpate::skills
