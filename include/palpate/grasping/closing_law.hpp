// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "palpate/hand/hand.hpp"

namespace palpate::grasping {

/// Torque limits of the closing law, N m, by the joint that an actuator drives.
struct ClosingTorque {
  double proximal = 0.1;       ///< J3 of the four fingers
  double distal = 0.07;        ///< J0 of the four fingers
  double thumb = 0.1;          ///< THJ5, THJ2
  double thumb_distal = 0.07;  ///< THJ1

  template <class Visitor>
  void visit(Visitor&& v) {
    v("proximal", proximal, 0.0, 5.0, "N m, J3 of the four fingers");
    v("distal", distal, 0.0, 5.0, "N m, J0 of the four fingers");
    v("thumb", thumb, 0.0, 5.0, "N m, THJ5 and THJ2");
    v("thumb_distal", thumb_distal, 0.0, 5.0, "N m, THJ1");
  }
};

/// The torque between a and b at share 0..1 of the way.
ClosingTorque blend(const ClosingTorque& a, const ClosingTorque& b, double share);

/// Closes fingers at a given speed, never pressing harder than a torque limit.
///
/// Each tick the setpoint advances, but leads the joint by at most torque / stiffness:
/// command = min(setpoint + rate dt, q + torque / stiffness). The lead is taken from the measured
/// torque, stiffness (command - q), so that the noise of the joint readings does not enter.
class ClosingLaw {
 public:
  /// @param rate  of J3, rad/s; the other joints close at fixed ratios to it
  /// @param thumb_limit  largest THJ5, rad
  ClosingLaw(const std::array<hand::Actuator, hand::kActuators>& actuators, double rate,
             double thumb_limit);

  /// Moves the commands of the active fingers by one tick.
  void advance(hand::HandCommand& command, const hand::HandReading& reading,
               const ClosingTorque& limit, const std::array<bool, hand::kFingers>& active) const;

 private:
  struct Drive {
    int actuator, finger;
    double rate;  // rad/s
    hand::Range range;
    double ClosingTorque::*limit;
  };
  std::array<hand::Actuator, hand::kActuators> actuators_;
  std::vector<Drive> drives_;
};

}  // namespace palpate::grasping
