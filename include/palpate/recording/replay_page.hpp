// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "palpate/hand/visuals.hpp"
#include "palpate/recording/recording.hpp"

namespace palpate::recording {

/// A page that replays the recording in any browser: one file that loads nothing else.
///
/// The hand is drawn from the recorded joints. Frames are thinned to at most 50 a second and 1500
/// in all, and as many beside in which another finger touches; meshes are coarsened where they are
/// fine. Times count from the whole second before the first frame. Without visuals the hand's
/// spheres are drawn instead.
/// @param page    HTML with the marks {{title}}, {{recording}} and {{script}}, in that order
/// @param script  the bundled viewer
/// @param title   plain text
/// @throws BadInput for a page without a mark, or visuals of a link or mesh that does not exist
std::string replay_page(const Recording& recording, const hand::HandVisuals& visuals,
                        std::string_view page, std::string_view script, std::string_view title);

/// Two such pages beside one another in one, that play together.
/// @param title  plain text
std::string compare_page(std::string_view left, std::string_view right, std::string_view title);

}  // namespace palpate::recording
