// SPDX-License-Identifier: Apache-2.0
#include "estimation/closing_push.hpp"

#include <algorithm>
#include <span>

#include "palpate/hand/kinematics.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::estimation {
namespace {

constexpr std::size_t kAveraged = 5;   // readings
constexpr std::size_t kMaxApart = 10;  // readings without a touch, that do not end it

/// The reading at which a finger met what it touches until `closed`; after it if it touches
/// nothing.
std::size_t first_of_touch(const EventLog& log, std::size_t finger, std::size_t closed) {
  std::size_t first = closed + 1;
  for (std::size_t i = closed + 1; i-- > 0 && first - i <= kMaxApart + 1;) {
    if (!log.readings[i].contacts[finger].empty()) first = i;
  }
  return first;
}

/// Pose of a finger's link in the world, by some readings.
Eigen::Isometry3d link_pose(const hand::Description& hand,
                            std::span<const hand::HandReading> readings, std::size_t finger) {
  const auto T_mount_link = hand::forward_kinematics(hand, tactile::mean_joints(readings));
  return readings.back().mount.pose() *
         T_mount_link[static_cast<std::size_t>(hand.fingers[finger].link)];
}

/// Of one finger.
double push_of(const hand::Description& hand, const EventLog& log, std::size_t finger,
               std::size_t first, std::size_t closed) {
  Eigen::Vector3d p = Eigen::Vector3d::Zero(), n = p;  // in the link's frame
  std::size_t last = first;
  for (std::size_t i = first; i <= closed; ++i) {
    for (const auto& contact : log.readings[i].contacts[finger]) {
      p = contact.p;
      n += contact.n;
      last = i;
    }
  }
  if (last < first + kAveraged) return 0;
  const std::span readings(log.readings);
  const auto T_first = link_pose(hand, readings.subspan(first, kAveraged), finger);
  const auto T_last = link_pose(hand, readings.subspan(last + 1 - kAveraged, kAveraged), finger);
  return -(T_last.linear() * n.normalized()).dot(T_last * p - T_first * p);
}

}  // namespace

double closing_push(const hand::Description& hand, const EventLog& log, std::size_t closed) {
  double farthest = 0;
  for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
    const std::size_t first = first_of_touch(log, finger, closed);
    if (first > closed) continue;
    farthest = std::max(farthest, push_of(hand, log, finger, first, closed));
  }
  return farthest;
}

}  // namespace palpate::estimation
