// SPDX-License-Identifier: Apache-2.0
#include "skills/grasp/predicted_contacts.hpp"

#include <optional>

#include "palpate/grasping/closing_trajectory.hpp"

namespace palpate::skills {
namespace {

constexpr double kNearObject = 0.01;  // m from it, of a fingertip that touches it
constexpr int kTipPoints = 5;         // of a fingertip's axis

/// Where a finger without contact data touches the object, by the object's pose; nothing where the
/// fingertip is not near it.
std::optional<tactile::Contact> contact_by_pose(const Executor& robot,
                                                const grasping::PlacedObject& object, int finger) {
  const hand::Finger& chain = robot.model().fingers[static_cast<std::size_t>(finger)];
  const auto& tip = chain.tip;
  const Eigen::Isometry3d T = hand::forward_kinematics(
      robot.model(), robot.reading().joints)[static_cast<std::size_t>(chain.link)];
  std::optional<tactile::Contact> nearest;
  double least = kNearObject;
  for (int i = 0; i < kTipPoints; ++i) {
    const double share = static_cast<double>(i) / (kTipPoints - 1);
    const Eigen::Vector3d p = T * ((1 - share) * tip.a + share * tip.b);
    const double distance = static_cast<double>(object.distance(p.cast<float>())) - tip.radius;
    if (distance >= least) continue;
    least = distance;
    nearest.emplace();
    nearest->finger = finger;
    nearest->n = object.normal(p.cast<float>());
    nearest->p = p - (tip.radius + distance) * nearest->n;
  }
  return nearest;
}

}  // namespace

void add_predicted_contacts(const Executor& robot, const geometry::ObjectModel& object,
                            const Eigen::Isometry3d& T_world_object,
                            std::vector<tactile::Contact>& contacts) {
  const grasping::PlacedObject placed(object, T_world_object, robot.reading().mount.pose());
  for (int finger = 0; finger < robot.model().finger_count(); ++finger) {
    if (robot.trust().trusted(finger)) continue;
    if (const auto contact = contact_by_pose(robot, placed, finger)) contacts.push_back(*contact);
  }
}

}  // namespace palpate::skills
