// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

#include "palpate/hand/description.hpp"

namespace palpate::hand {

/// Fingers of the Shadow hand and of the human one.
enum class FingerName { thumb, first, middle, ring, little };  ///< TH, FF, MF, RF, LF
inline constexpr int kShadowFingers = 5;
inline constexpr std::array<std::string_view, kShadowFingers> kShadowFingerNames = {
    "TH", "FF", "MF", "RF", "LF"};

inline constexpr int kShadowJoints = 24;
/// Order of the Shadow hand's joints. Numbered from the tip to the base, as in thesis table A.1.
inline constexpr std::array<std::string_view, kShadowJoints> kShadowJointNames = {
    "WRJ2", "WRJ1", "THJ5", "THJ4", "THJ3", "THJ2", "THJ1", "FFJ4", "FFJ3", "FFJ2", "FFJ1", "MFJ4",
    "MFJ3", "MFJ2", "MFJ1", "RFJ4", "RFJ3", "RFJ2", "RFJ1", "LFJ5", "LFJ4", "LFJ3", "LFJ2", "LFJ1"};

inline constexpr int kShadowActuators = 20;
/// Order of its actuators. J0 drives the coupled pair: its value is J1 + J2.
inline constexpr std::array<std::string_view, kShadowActuators> kShadowActuatorNames = {
    "WRJ2", "WRJ1", "THJ5", "THJ4", "THJ3", "THJ2", "THJ1", "FFJ4", "FFJ3", "FFJ0",
    "MFJ4", "MFJ3", "MFJ0", "RFJ4", "RFJ3", "RFJ0", "LFJ5", "LFJ4", "LFJ3", "LFJ0"};

/// What is known of the Shadow Dexterous Hand beside its MJCF: joints with the ranges of thesis
/// table A.1, actuators and their coupling, postures. Links, tips and gains are the MJCF's.
const Description& shadow_hand();

/// Joints of the human hand that move together, named as in thesis table A.3, and their range.
struct HumanRange {
  std::string_view joints;
  Range range;
};

/// Range of motion of the human hand (thesis table A.2).
inline constexpr std::array<HumanRange, 8> kHumanRanges = {{
    {"TH1", {-0.262, 1.396}},
    {"TH2+TH3", {-0.175, 0.960}},
    {"TH4+TH5", {-0.175, 0.960}},
    {"FF1 MF1 RF1 LF1", {0.0, 1.396}},
    {"FF2 MF2 RF2 LF2", {0.0, 1.745}},
    {"FF3 MF3 RF3 LF3", {-0.785, 1.571}},
    {"WR1", {-1.396, 1.396}},
    {"WR2", {-0.489, 0.349}},
}};

}  // namespace palpate::hand
