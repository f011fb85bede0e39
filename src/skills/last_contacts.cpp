// SPDX-License-Identifier: Apache-2.0
#include "skills/last_contacts.hpp"

#include "palpate/hand/tip_forces.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {

std::optional<Eigen::Vector2d> place_of_last_contacts(const Executor& robot) {
  const auto& readings = robot.log().readings;
  for (auto reading = readings.rbegin(); reading != readings.rend(); ++reading) {
    if (hand::count_contacts(*reading) < 2) continue;
    const auto T_mount_link = hand::forward_kinematics(robot.model(), reading->joints);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (std::size_t finger = 0; finger < robot.model().fingers.size(); ++finger) {
      const auto link = static_cast<std::size_t>(robot.model().fingers[finger].link);
      for (const auto& contact : reading->contacts[finger]) {
        sum += T_mount_link[link] * contact.p;
        ++count;
      }
    }
    return (reading->mount.pose() * (sum / count)).head<2>();
  }
  return std::nullopt;
}

}  // namespace palpate::skills
