// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/hand/description.hpp"
#include "skills/explore/calibration_touches.hpp"

namespace palpate::skills {

inline constexpr double kTravelHeight = 0.02;  ///< m of the hand's lowest part on the way

/// Lifts the mount by a way, m.
void rise(Executor& robot, double way, double speed);

/// Height of the hand's lowest part over the mount's in the posture of a touch, m.
double lowest(const hand::Description& hand, const CalibrationTouch& touch);

/// Takes the attitude of a touch well above the table; where fingers would meet one another on the
/// way, by the stretched hand.
void take_attitude(Executor& robot, const CalibrationTouch& touch, const CalibrateOptions& options);

/// Whether the mount can come to the table in this attitude.
bool is_reachable(const Executor& robot, const CalibrationTouch& touch,
                  const CalibrateOptions& options);

/// How a fingertip that came down met the table.
struct TablePress {
  bool met = false;  ///< a fingertip reports contact, or the mount bears a load
  std::optional<int>
      reported_by;  ///< the fingertip that reports contact; its own goes before others

  [[nodiscard]] bool sensed_by(int finger) const { return reported_by == finger; }
};

/// For each fingertip, the presses in a row on something that it did not sense itself, and the
/// other one that reported all of them.
class UnsensedPresses {
 public:
  /// @param press  of this fingertip, that has met something
  void add(int finger, const TablePress& press);
  void forget(int finger) { of_[static_cast<std::size_t>(finger)] = {}; }
  [[nodiscard]] int count(int finger) const { return of_[static_cast<std::size_t>(finger)].count; }
  /// The fingertip that reports what this one presses on, and whose own presses this one reports,
  /// each at least `count` times in a row.
  [[nodiscard]] std::optional<int> swapped_with(int finger, int count) const;
  /// The fingertip that reported all unsensed presses of this one.
  [[nodiscard]] std::optional<int> reporter(int finger) const {
    return of_[static_cast<std::size_t>(finger)].reporter;
  }

 private:
  struct OfFinger {
    int count = 0;
    std::optional<int> reporter;
  };
  hand::PerFinger<OfFinger> of_{};
};

/// Comes down until the fingertip senses the table, the mount bears a load that it does not sense,
/// or the mount is at `height`, m.
TablePress press_table(Executor& robot, const CalibrationTouch& touch,
                       const CalibrateOptions& options, double height);

}  // namespace palpate::skills
