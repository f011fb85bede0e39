// SPDX-License-Identifier: Apache-2.0
#include "skills/motion/lowest_part.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::skills {

hand::Attitude attitude_of(const hand::MountPosition& mount) {
  return {mount.ypr.y(), mount.ypr.z()};
}

double lowest_part(const hand::Description& hand, const hand::ActuatorVector& posture,
                   const hand::Attitude& attitude, const std::function<bool(int link)>& counts) {
  const auto T_mount_link =
      hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, posture));
  hand::MountPosition mount;
  mount.ypr << 0, attitude.pitch, attitude.roll;
  const Eigen::RowVector3d up = mount.pose().linear().row(2);
  double low = std::numeric_limits<double>::infinity();
  for (const hand::LinkSphere& ball : hand.spheres) {
    if (counts && !counts(ball.link)) continue;
    const auto& T = T_mount_link[static_cast<std::size_t>(ball.link)];
    low = std::min(low, up.dot(T * ball.center) - ball.radius);
  }
  return low;
}

double hollow_depth(const hand::Description& hand) {
  const hand::FlatHand& flat = hand.postures.flat;
  double highest = -std::numeric_limits<double>::infinity();
  for (std::size_t link = 0; link < hand.links.size(); ++link) {
    const double low = lowest_part(hand, flat.positions, flat.attitude,
                                   [&](int i) { return i == static_cast<int>(link); });
    if (std::isfinite(low)) highest = std::max(highest, low);
  }
  return highest - lowest_part(hand, flat.positions, flat.attitude);
}

double lowest_on_way(const hand::Description& hand, const hand::ActuatorVector& from,
                     const hand::Attitude& from_attitude, const hand::ActuatorVector& to,
                     const hand::Attitude& to_attitude) {
  constexpr int kLooks = 8;
  double low = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kLooks; ++i) {
    const double share = static_cast<double>(i) / kLooks;
    const auto between = [share](double a, double b) { return a + share * (b - a); };
    low = std::min(low, lowest_part(hand, from + share * (to - from),
                                    {between(from_attitude.pitch, to_attitude.pitch),
                                     between(from_attitude.roll, to_attitude.roll)}));
  }
  return low;
}

}  // namespace palpate::skills
