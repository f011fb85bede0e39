// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "palpate/hand/visuals.hpp"
#include "palpate/recording/recording.hpp"

namespace palpate::recording {

/// All that the replay page shows, as viewer/recording.js reads it: plain JSON, long series as
/// base64 of little-endian numbers, poses as x, y, z, qx, qy, qz, qw.
nlohmann::json page_data(const Recording& recording, const hand::HandVisuals& visuals);

/// Meshes, and which link carries which: "meshes", "parts", "spheres", "object_mesh".
nlohmann::json page_shapes(const Recording& recording, const hand::HandVisuals& visuals);

/// Phases, the place for the object, beliefs, and estimates with their errors: "phases",
/// "placement", "beliefs", "estimates".
nlohmann::json page_story(const Recording& recording);

// Parts of it, for a page that is shown while they come about.

/// The series of one frame.
nlohmann::json frame_to_json(const Frame& frame, const hand::Description& hand);
/// "phases", of which those that have not ended last to the time `last`, and "placement".
nlohmann::json events_to_json(const std::vector<Event>& events, double last);
/// @param truth  at the time of the estimate or belief, if known, for their errors
nlohmann::json estimate_to_json(const EstimateRecord& estimate, const FrameTruth* truth,
                                const std::vector<Eigen::Matrix3d>& symmetries);
nlohmann::json belief_to_json(const BeliefRecord& belief, const FrameTruth* truth,
                              const std::vector<Eigen::Matrix3d>& symmetries);
/// Whether a note lists the credible poses of the resting object, and these.
bool holds_belief(const Event& event);
BeliefRecord belief_of(const Event& event);

}  // namespace palpate::recording
