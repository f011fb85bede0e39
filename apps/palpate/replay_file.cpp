// SPDX-License-Identifier: Apache-2.0
#include "replay_file.hpp"

#include "palpate/core/assets.hpp"
#include "palpate/core/file.hpp"
#include "palpate/recording/replay_page.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::app {

std::string replay_html(const std::filesystem::path& recording, const std::string& title) {
  const auto visuals = simulation::load_shadow_hand_visuals(asset("shadow_hand/right_hand.xml"));
  return recording::replay_page(recording::read_recording(recording), visuals,
                                read_file(asset("page.html")), read_file(asset("viewer.js")),
                                title);
}

}  // namespace palpate::app
