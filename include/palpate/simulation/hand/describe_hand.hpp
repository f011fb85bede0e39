// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpate/hand/description.hpp"

namespace palpate::simulation {

/// What a user says of a hand beside its model file; empty means: find out.
struct HandNotes {
  std::string root;                  ///< the hand's first body; its own joints are left out
  std::string palm;                  ///< body that the fingers sprout from
  std::vector<std::string> tips;     ///< bodies of the fingertips, in the order of the fingers
  std::vector<std::string> fingers;  ///< their names
  std::string thumb;                 ///< name of the finger that closes against the others
  double max_torque = 0;             ///< N m, of every joint; 0: the file's
};

/// Something wrong with a hand's file, and what can be done about it.
struct HandProblem {
  std::string what, hint;
};

/// A hand as its model file has it: links, joints, drives, fingertips and mount. Postures are
/// grasping::derive_postures()'.
struct DescribedHand {
  hand::Description hand;
  std::vector<std::string> guesses;   ///< what the file does not say, in words
  std::vector<HandProblem> problems;  ///< that do not keep it from being used
};

/// Reads a hand from an MJCF or URDF file.
///
/// Fingers are the chains of hinges below the palm, fingertips the last body of each that can
/// collide, for whose surface a capsule is fitted. Hinges that an equality or a mimic ties to
/// another one follow it. Every other hinge gets a position servo; where the file has none, by a
/// rule: 300 N/m at the fingertip, critically damped.
/// @throws BadInput for a file that cannot be used, with what to do about it
DescribedHand describe_hand(const std::filesystem::path& file, const HandNotes& notes = {});

}  // namespace palpate::simulation
