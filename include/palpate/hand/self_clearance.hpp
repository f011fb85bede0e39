// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <utility>
#include <vector>

#include "palpate/hand/kinematics.hpp"

namespace palpate::hand {

/// Determines whether a hand can take a posture without its fingers pressing on one another or on
/// the palm: no links come within 2 mm of each other that do not in a posture which it can take.
class SelfClearance {
 public:
  /// Keeps a reference: the hand must outlive it.
  /// @param possible  joints of a posture that the hand can take
  SelfClearance(const Description& hand, const JointVector& possible);

  bool is_clear(const JointVector& joints) const;

 private:
  using LinkPairs = std::set<std::pair<int, int>>;

  LinkPairs close_links(const JointVector& joints) const;
  bool may_meet(const LinkSphere& ball, const LinkSphere& other) const;

  const Description& hand_;
  std::vector<int> finger_;  // that carries each link; -1: the palm and what is before it
  std::vector<bool> outer_;  // whether each link is so far out that it may meet the palm
  LinkPairs possible_;
};

}  // namespace palpate::hand
