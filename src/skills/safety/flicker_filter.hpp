// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "palpate/hand/hand.hpp"

namespace palpate::skills {

/// Takes out the contacts that a noisy tactile sensor reports where nothing touches.
///
/// A real contact lasts: the next reading has one nearby, too. A fingertip that reports single
/// readings of contact again and again is noisy, and from then on only those of its contacts count
/// that have been there for kLasting readings. Other fingertips are not delayed.
class FlickerFilter {
 public:
  static constexpr int kLasting = 5;  ///< readings

  /// @param contacts  of the fingertip in this reading; what is noise is taken out
  void filter(int finger, std::vector<hand::TipContact>& contacts);
  [[nodiscard]] bool noisy(int finger) const {
    return fingers_[static_cast<std::size_t>(finger)].noisy;
  }

 private:
  using Points = std::vector<Eigen::Vector3d>;  // m, in the distal link's frame
  struct Finger {
    std::array<Points, kLasting - 1> before;  // of the last readings, the newest first
    double flashes = 0;                       // of late: single readings of contact
    bool noisy = false;
  };

  hand::PerFinger<Finger> fingers_;
};

}  // namespace palpate::skills
