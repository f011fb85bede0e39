// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include "palpate/tactile/biotac/log.hpp"

namespace palpate::tactile {

/// Follows the rest values of a BioTac's stream from the frames that have come so far.
///
/// A frame is quiet while the median pressure of the last frames lies within 6 counts of its lower
/// envelope, which may rise by 2 counts a second. Rest is known after ten quiet frames in a row,
/// and then follows quiet frames, all but the newest three, in which a touch may have begun. Where
/// the pressure falls below rest by more than 6 counts, what was taken for rest was a touch, and
/// rest is unknown again.
class BiotacRestTracker {
 public:
  /// @param time      s; a step back counts as none
  /// @param channels  counts, all finite
  /// @return the rest values at that time, counts; nothing while they are not known
  const std::optional<BiotacChannels>& step(double time, const BiotacChannels& channels);

 private:
  BiotacChannels median_of_last() const;
  void follow(const BiotacChannels& quiet);

  std::deque<BiotacChannels> last_, quiet_;  // the newest at the back
  std::optional<BiotacChannels> rest_;
  double time_ = 0, envelope_ = 0;  // s, counts
};

}  // namespace palpate::tactile
