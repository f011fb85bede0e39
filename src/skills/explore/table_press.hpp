// SPDX-License-Identifier: Apache-2.0
#pragma once

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
enum class TablePress { missed, sensed, unsensed };

/// Comes down until the fingertip senses the table, the mount bears a load that it does not sense,
/// or the mount is at `height`, m.
TablePress press_table(Executor& robot, const CalibrationTouch& touch,
                       const CalibrateOptions& options, double height);

}  // namespace palpate::skills
