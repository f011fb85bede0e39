// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "palpate/hand/description.hpp"
#include "palpate/hand/visuals.hpp"

namespace palpate::app {

/// Whether two hands have the same links, each in its place but for errors of calibration.
bool same_links(const hand::Description& a, const hand::Description& b);

/// The hand of a recording as its own file describes it now.
/// @throws BadInput if that file is not here, cannot be used, or is of another hand
hand::Description load_recorded_hand(const hand::Description& recorded);

/// What the hand of a recording looks like. Where its file cannot say, nothing, so that the
/// recorded spheres are drawn; then says why on stderr.
hand::HandVisuals visuals_of(const hand::Description& recorded);

/// The one-file page that replays a recording, with its hand drawn.
/// @throws BadInput for a recording that cannot be read, or if the viewer's files are missing
std::string replay_html(const std::filesystem::path& recording, const std::string& title);

}  // namespace palpate::app
