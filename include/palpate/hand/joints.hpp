// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>

namespace palpate::hand {

enum class Finger { thumb, first, middle, ring, little };  ///< TH, FF, MF, RF, LF
inline constexpr int kFingers = 5;
inline constexpr std::array<std::string_view, kFingers> kFingerNames = {"TH", "FF", "MF", "RF",
                                                                        "LF"};

inline constexpr int kJoints = 24;
/// Order of all joint vectors. Numbered from the tip to the base, as in thesis table A.1.
inline constexpr std::array<std::string_view, kJoints> kJointNames = {
    "WRJ2", "WRJ1", "THJ5", "THJ4", "THJ3", "THJ2", "THJ1", "FFJ4", "FFJ3", "FFJ2", "FFJ1", "MFJ4",
    "MFJ3", "MFJ2", "MFJ1", "RFJ4", "RFJ3", "RFJ2", "RFJ1", "LFJ5", "LFJ4", "LFJ3", "LFJ2", "LFJ1"};

inline constexpr int kActuators = 20;
/// Order of all actuator vectors. J0 drives the coupled pair: its value is J1 + J2.
inline constexpr std::array<std::string_view, kActuators> kActuatorNames = {
    "WRJ2", "WRJ1", "THJ5", "THJ4", "THJ3", "THJ2", "THJ1", "FFJ4", "FFJ3", "FFJ0",
    "MFJ4", "MFJ3", "MFJ0", "RFJ4", "RFJ3", "RFJ0", "LFJ5", "LFJ4", "LFJ3", "LFJ0"};

using JointVector = Eigen::Matrix<double, kJoints, 1>;        ///< rad
using ActuatorVector = Eigen::Matrix<double, kActuators, 1>;  ///< rad or N m

/// @throws BadInput for a name that is not in kJointNames (kActuatorNames)
int joint_index(std::string_view name);
int actuator_index(std::string_view name);

/// Finger that an actuator moves; nothing for the wrist (returned as -1).
int finger_of_actuator(int actuator);

/// Actuator coordinates of joint angles: J0 = J1 + J2.
ActuatorVector actuator_positions(const JointVector& joints);

struct Range {
  double low, high;  ///< rad
};

/// Range of motion of the Shadow hand (thesis table A.1) and of the human hand (table A.2).
const std::array<Range, kJoints>& shadow_ranges();
const std::array<Range, kJoints>& human_ranges();

}  // namespace palpate::hand
