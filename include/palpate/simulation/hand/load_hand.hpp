// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "palpate/core/progress.hpp"
#include "palpate/hand/description.hpp"
#include "palpate/hand/visuals.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"

namespace palpate::simulation {

/// The hand of a name, or of a model file. A process reads each hand once.
/// @param name  "shadow" or empty, "shadow-left", another of stored_hands(), or the path of an MJCF
///              or URDF file, or of a TOML file with HandNotes
/// @param stiffness_scale  of the position controllers of the Shadow hand's fingers
/// @throws BadInput if there is no such hand or its file cannot be used
hand::Description load_hand(const std::string& name, double stiffness_scale = 4.0);

/// The same, with what was guessed and what is wrong with the file. Where no postures are found,
/// the hand has none, and `failure` says why.
/// @param progress  called while postures are searched for, which takes about a minute the first
/// time
DescribedHand load_described_hand(const std::string& name, double stiffness_scale = 4.0,
                                  const ProgressCallback& progress = {});

/// The Shadow hand's model, read from its MJCF.
/// @throws BadInput if the file is missing or lacks a link or joint of the hand
hand::Description load_shadow_hand(const std::filesystem::path& mjcf, double stiffness_scale = 4.0);

/// What a hand looks like: the drawn meshes of its file, for its links.
/// @throws BadInput if the file cannot be used
hand::HandVisuals load_hand_visuals(const hand::Description& hand);

}  // namespace palpate::simulation
