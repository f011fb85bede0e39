// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
#include <string>
#include <string_view>

#include "palpate/hand/description.hpp"

namespace palpate::grasping {

/// What the search for a preshape finds.
struct HandPosture {
  /// Shares of the way to closed at which fingers and thumb are open: first joints, outer joints.
  std::array<double, 2> fingers{}, thumb{};
  double curl = 1;  ///< speed of the outer joints, relative to their ranges
  hand::ActuatorVector
      opposition;  ///< shares of their ranges at which the thumb's first joints stand
  hand::Attitude attitude;
  double cost = std::numeric_limits<double>::infinity();
};

/// All numbers of a hand that the search depends on, as text.
/// @param kind  of hand, which decides how it is searched
std::string fingerprint(const hand::Description& hand, std::string_view kind);

/// What the search has found, as kept in the cache: the posture, and the other attitude.
std::string to_bytes(const HandPosture& best, const hand::Attitude& other);

/// The same, read. @return whether the bytes are those of a hand with so many actuators
bool from_bytes(const std::string& bytes, int actuators, HandPosture& best, hand::Attitude& other);

}  // namespace palpate::grasping
