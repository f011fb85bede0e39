// SPDX-License-Identifier: Apache-2.0
#include "replay_file.hpp"

#include "palpate/core/assets.hpp"
#include "palpate/core/file.hpp"
#include "palpate/recording/replay_page.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::app {

std::string replay_html(const std::filesystem::path& recording, const std::string& title) {
  const recording::Recording picked = recording::read_recording(recording);
  const auto hand = simulation::load_hand(picked.header.hand.name);
  return recording::replay_page(picked, simulation::load_hand_visuals(hand),
                                read_file(asset("page.html")), read_file(asset("viewer.js")),
                                title);
}

}  // namespace palpate::app
