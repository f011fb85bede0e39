// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/finger_trust.hpp"

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

}  // namespace palpate::skills
