// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/tip_forces.hpp"

#include <algorithm>

namespace palpate::hand {
namespace {

double normal_force(const TipContact& contact) {
  return contact.n.isZero(0) ? contact.f.norm() : -contact.f.dot(contact.n);
}

}  // namespace

int count_contacts(const HandReading& reading, double least) {
  int count = 0;
  for (const auto& tip : reading.contacts) {
    count += static_cast<int>(std::count_if(tip.begin(), tip.end(), [&](const auto& contact) {
      return normal_force(contact) > least;
    }));
  }
  return count;
}

int touching_fingers(const HandReading& reading) {
  return static_cast<int>(
      std::ranges::count_if(reading.contacts, [](const auto& finger) { return !finger.empty(); }));
}

double tip_force(const HandReading& reading, int finger) {
  double force = 0;
  for (const auto& contact : reading.contacts[static_cast<std::size_t>(finger)]) {
    force = std::max(force, normal_force(contact));
  }
  return force;
}

double distance_from_tip(const Eigen::Vector3d& p, const Finger& finger) {
  if (finger.link < 0) return 0;
  const Eigen::Vector3d axis = finger.tip.b - finger.tip.a;
  const double length = axis.squaredNorm();
  const double share = length > 0 ? std::clamp(axis.dot(p - finger.tip.a) / length, 0.0, 1.0) : 0.0;
  return std::max(0.0, (p - finger.tip.a - share * axis).norm() - finger.tip.radius);
}

}  // namespace palpate::hand
