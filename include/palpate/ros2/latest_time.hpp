// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace palpate::ros2 {

/// Where the time of a message stands among those of its kind that came before.
enum class TimeOrder {
  later,
  late,      ///< not later than the latest one
  set_back,  ///< the sender's clock was set back, and goes on from here
};

/// Time of the latest message of one kind, ns; 0 before the first one.
///
/// A single early time is of a message that is late. Many in a row, which follow one another and
/// between which nothing later comes, are those of a clock that was set back: a simulation or a bag
/// that begins again, or one message of a wrong, far later time before them.
class LatestTime {
 public:
  TimeOrder take(std::uint64_t time);

  /// Taken for the latest one without a comparison.
  void set(std::uint64_t time) { time_ = time; }
  std::uint64_t time() const { return time_; }

 private:
  std::uint64_t time_ = 0;
  std::uint64_t early_ = 0;  ///< the latest of those that would be of a clock set back
  int early_count_ = 0;
};

}  // namespace palpate::ros2
