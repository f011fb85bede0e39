// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/hand/hand.hpp"

namespace palpate::hand {

/// One joint of a finger or of the wrist.
struct JointReading {
  std::string_view name;
  double angle = 0;  ///< rad
};

/// One actuator of a finger or of the wrist.
struct DriveReading {
  std::string_view name;
  double torque = 0;  ///< N m
};

/// What one finger senses in a tick, as the thesis' ShadowFinger (section 2.2.2, figure 2.6a).
struct FingerReading {
  double time = 0;                   ///< s
  std::vector<JointReading> joints;  ///< from the base to the tip
  std::vector<DriveReading> drives;
  std::vector<TipContact> contacts;
};

/// What the wrist senses in a tick, as the thesis' ShadowWrist.
struct WristReading {
  double time = 0;  ///< s
  std::vector<JointReading> joints;
  std::vector<DriveReading> drives;
};

/// The reader of a finger: its part of every reading of the hand, 100 a second.
FingerReading finger_reading(const HandReading& reading, Finger finger);

/// The reader of the wrist.
WristReading wrist_reading(const HandReading& reading);

}  // namespace palpate::hand
