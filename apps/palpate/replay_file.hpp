// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace palpate::app {

/// The one-file page that replays a recording, with the Shadow hand drawn.
/// @throws BadInput for a recording that cannot be read, or if the viewer's files are missing
std::string replay_html(const std::filesystem::path& recording, const std::string& title);

}  // namespace palpate::app
