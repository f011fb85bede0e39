// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/tip_forces.hpp"

#include <algorithm>

namespace palpate::hand {

int count_contacts(const HandReading& reading, double least) {
  int count = 0;
  for (const auto& tip : reading.contacts) {
    count += static_cast<int>(std::count_if(tip.begin(), tip.end(), [&](const auto& contact) {
      return -contact.f.dot(contact.n) > least;
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
    force = std::max(force, -contact.f.dot(contact.n));
  }
  return force;
}

}  // namespace palpate::hand
