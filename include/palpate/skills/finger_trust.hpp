// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "palpate/hand/description.hpp"

namespace palpate::skills {

/// Which fingertips are believed in what they sense: all, at first.
class FingerTrust {
 public:
  bool trusted(int finger) const { return !distrusted_[static_cast<std::size_t>(finger)]; }

  /// Something has held up this finger, which sensed nothing. Ignored once it was cleared.
  void suspect(int finger) { suspected_[static_cast<std::size_t>(finger)] = true; }
  /// Whether this finger is believed, but has been held up by what it did not sense.
  bool suspected(int finger) const;
  std::vector<int> suspects() const;
  /// The finger's sensor works: what held it up did not touch its tip.
  void clear(int finger) { cleared_[static_cast<std::size_t>(finger)] = true; }
  bool cleared(int finger) const { return cleared_[static_cast<std::size_t>(finger)]; }

 private:
  friend class Executor;  // which makes a fault of it
  void distrust(int finger) { distrusted_[static_cast<std::size_t>(finger)] = true; }

  hand::PerFinger<bool> distrusted_{}, suspected_{}, cleared_{};
};

}  // namespace palpate::skills
