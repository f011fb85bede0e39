// SPDX-License-Identifier: Apache-2.0
#include "replay_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/recording/replay_page.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::app {

bool same_links(const hand::Description& a, const hand::Description& b) {
  static constexpr double kSamePlace = 0.02;  // m: links are believed some 2 mm off
  static constexpr double kSameTurn = 0.2;    // rad
  return std::ranges::equal(a.links, b.links, [](const hand::Link& x, const hand::Link& y) {
    const Eigen::Isometry3d T_x_y = x.T_parent_link.inverse() * y.T_parent_link;
    return x.name == y.name && x.parent == y.parent && T_x_y.translation().norm() < kSamePlace &&
           Eigen::AngleAxisd(T_x_y.linear()).angle() < kSameTurn;
  });
}

hand::Description load_recorded_hand(const hand::Description& recorded) {
  auto hand = simulation::load_hand(recorded.name);
  // An episode by touch holds the Adroit hand in the links of the Shadow hand.
  const bool built_in = recorded.name == "shadow" || recorded.name == "shadow-left";
  if (built_in || same_links(hand, recorded)) return hand;
  throw BadInput(
      fmt::format("{} is of another hand than the one that was recorded", recorded.name));
}

hand::HandVisuals visuals_of(const hand::Description& recorded) {
  try {
    return simulation::load_hand_visuals(load_recorded_hand(recorded));
  } catch (const BadInput& error) {
    fmt::print(stderr, "palpate: the hand is drawn as its recorded spheres: {}\n", error.what());
    return {};
  }
}

std::string replay_html(const std::filesystem::path& recording, const std::string& title) {
  const recording::Recording picked = recording::read_recording(recording);
  return recording::replay_page(picked, visuals_of(picked.header.hand),
                                read_file(asset("page.html")), read_file(asset("viewer.js")),
                                title);
}

}  // namespace palpate::app
