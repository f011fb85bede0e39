// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "palpate/hand/hand.hpp"

namespace palpate::skills {

/// Which fingertips are believed in what they sense: all, at first, and each about itself.
class FingerTrust {
 public:
  bool trusted(int finger) const { return !distrusted_[static_cast<std::size_t>(finger)]; }
  bool all_trusted() const;

  /// Something has held up this finger, which sensed nothing. Ignored once it was cleared.
  void suspect(int finger) { suspected_[static_cast<std::size_t>(finger)] = true; }
  /// Whether this finger is believed, but has been held up by what it did not sense.
  bool suspected(int finger) const;
  std::vector<int> suspects() const;
  /// The finger's sensor works: what held it up did not touch its tip.
  void clear(int finger) { cleared_[static_cast<std::size_t>(finger)] = true; }
  /// Neither suspected nor cleared: whether its sensor works was not found out.
  void end_suspicion(int finger) { suspected_[static_cast<std::size_t>(finger)] = false; }
  bool cleared(int finger) const { return cleared_[static_cast<std::size_t>(finger)]; }

  /// Gives every fingertip the contacts that another one reports for it.
  void assign_contacts(hand::HandReading& reading) const;

 private:
  friend class Executor;  // which makes a fault of it
  void distrust(int finger) { distrusted_[static_cast<std::size_t>(finger)] = true; }
  void swap(int finger, int other) { swapped_.emplace_back(finger, other); }

  hand::PerFinger<bool> distrusted_{}, suspected_{}, cleared_{};
  std::vector<std::pair<int, int>> swapped_;  // fingers that report each other's contacts
};

}  // namespace palpate::skills
