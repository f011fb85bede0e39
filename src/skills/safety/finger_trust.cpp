// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/finger_trust.hpp"

#include <algorithm>
#include <utility>

namespace palpate::skills {

bool FingerTrust::suspected(int finger) const {
  return suspected_[static_cast<std::size_t>(finger)] && trusted(finger) && !cleared(finger);
}

std::vector<int> FingerTrust::suspects() const {
  std::vector<int> fingers;
  for (int finger = 0; finger < hand::kMaxFingers; ++finger) {
    if (suspected(finger)) fingers.push_back(finger);
  }
  return fingers;
}

bool FingerTrust::all_trusted() const {
  return std::ranges::none_of(distrusted_, [](bool distrusted) { return distrusted; });
}

void FingerTrust::assign_contacts(hand::HandReading& reading) const {
  for (const auto& [finger, other] : swapped_) {
    const auto a = static_cast<std::size_t>(finger), b = static_cast<std::size_t>(other);
    if (std::max(a, b) < reading.contacts.size())
      std::swap(reading.contacts[a], reading.contacts[b]);
    if (std::max(a, b) < reading.biotacs.size()) std::swap(reading.biotacs[a], reading.biotacs[b]);
  }
}

}  // namespace palpate::skills
