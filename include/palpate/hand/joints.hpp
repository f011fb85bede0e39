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

/// Finger (index into kFingerNames) that an actuator moves; -1 for the wrist.
int finger_of_actuator(int actuator);

/// Actuator coordinates of joint angles: J0 = J1 + J2.
ActuatorVector actuator_positions(const JointVector& joints);

struct Range {
  double low, high;  ///< rad
};

/// Range of motion of the Shadow hand (thesis table A.1).
const std::array<Range, kJoints>& shadow_ranges();

/// Joints of the human hand that move together, named as in thesis table A.3, and their range.
struct HumanRange {
  std::string_view joints;
  std::string_view latin_name;
  Range range;
};

/// Range of motion of the human hand (thesis table A.2).
inline constexpr std::array<HumanRange, 8> kHumanRanges = {{
    {"TH1", "interphalangeal", {-0.262, 1.396}},
    {"TH2+TH3", "metacarpophalangeal", {-0.175, 0.960}},
    {"TH4+TH5", "carpometacarpal", {-0.175, 0.960}},
    {"FF1 MF1 RF1 LF1", "distal interphalangeal", {0.0, 1.396}},
    {"FF2 MF2 RF2 LF2", "proximal interphalangeal", {0.0, 1.745}},
    {"FF3 MF3 RF3 LF3", "metacarpophalangeal", {-0.785, 1.571}},
    {"WR1", "radiocarpal", {-1.396, 1.396}},
    {"WR2", "radiocarpal", {-0.489, 0.349}},
}};

}  // namespace palpate::hand
