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

/// Phases, notes, the place for the object, and estimates with their errors: "phases", "notes",
/// "placement", "estimates".
nlohmann::json page_story(const Recording& recording);

}  // namespace palpate::recording
