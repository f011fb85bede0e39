// SPDX-License-Identifier: Apache-2.0
#include "estimation/in_hand_motion.hpp"

#include <algorithm>
#include <vector>

#include "estimation/event_window.hpp"

namespace palpate::estimation {
namespace {

constexpr std::size_t kCarriedStep = 10;  // readings between looks at what carries the object
constexpr double kCarriedWindow = 0.1;    // s of them that are averaged

/// The line through the contacts, or all axes through the only one.
std::vector<localization::FreeAxis> axes_through(const std::vector<Eigen::Vector3d>& contacts) {
  constexpr double kOneSpot = 0.004;  // m
  const Eigen::Vector3d along = contacts.back() - contacts.front();
  if (along.norm() > kOneSpot) return {{contacts.front(), along.normalized()}};
  std::vector<localization::FreeAxis> axes;
  for (int i = 0; i < 3; ++i) axes.push_back({contacts.front(), Eigen::Vector3d::Unit(i)});
  return axes;
}

/// How an object moves in the hand's mount from one window of readings to the next: as the
/// fingertips do where they touch it. With less than three fingers only the displacement is known.
InHandMotion carried_step(const hand::Description& hand, std::span<const hand::HandReading> before,
                          std::span<const hand::HandReading> after,
                          const tactile::ContactErrorModel& errors, const Fingers& ignored) {
  const auto T_before = hand::forward_kinematics(hand, tactile::mean_joints(before));
  const auto T_after = hand::forward_kinematics(hand, tactile::mean_joints(after));
  Fingers touched{};
  for (const auto& contact : tactile::lasting_contacts(before, hand, errors)) {
    const auto finger = static_cast<std::size_t>(contact.finger);
    touched[finger] = !ignored[finger];
  }
  std::vector<Eigen::Vector3d> from, to;
  Fingers carry{};
  for (const auto& contact : tactile::lasting_contacts(after, hand, errors)) {
    const auto finger = static_cast<std::size_t>(contact.finger);
    if (!touched[finger]) continue;
    const auto link = static_cast<std::size_t>(hand.fingers[finger].link);
    from.push_back(T_before[link] * (T_after[link].inverse() * contact.p));
    to.push_back(contact.p);
    carry[finger] = true;
  }
  InHandMotion motion;
  if (from.empty()) return motion;
  const bool turn_is_known = std::ranges::count(carry, true) >= 3;
  if (!turn_is_known) motion.loose = axes_through(to);
  const auto count = static_cast<Eigen::Index>(from.size());
  const Eigen::Map<const Eigen::Matrix3Xd> P(from.data()->data(), 3, count);
  const Eigen::Map<const Eigen::Matrix3Xd> Q(to.data()->data(), 3, count);
  if (turn_is_known) {
    motion.T.matrix() = Eigen::umeyama(P, Q, false);
  } else {
    motion.T.translation() = (Q - P).rowwise().mean();
  }
  return motion;
}

}  // namespace

InHandMotion in_hand_motion(const hand::Description& hand, const EventLog& log, std::size_t first,
                            std::size_t last, const tactile::ContactErrorModel& errors,
                            const Fingers& ignored) {
  InHandMotion motion;
  std::size_t done = first;
  while (done < last) {
    const std::size_t next = last - done < 2 * kCarriedStep ? last : done + kCarriedStep;
    const InHandMotion step =
        carried_step(hand, window_before(log, done, kCarriedWindow),
                     window_before(log, next, kCarriedWindow), errors, ignored);
    motion.T = step.T * motion.T;
    if (!step.loose.empty() && log.hangs_at(next)) motion.loose = step.loose;
    done = next;
  }
  return motion;
}

}  // namespace palpate::estimation
