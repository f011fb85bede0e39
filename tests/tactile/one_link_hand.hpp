// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hand/descriptions.hpp"

namespace palpate::hand {

/// All fingertips on one link that flexes about x, each a capsule along z.
inline Description one_link_hand() {
  Description hand = shadow_on_link(0, {{0, 0, 0.002}, {0, 0, 0.02}, 0.007});
  hand.links = {{"distal", -1, Eigen::Isometry3d::Identity(), Eigen::Vector3d::UnitX(), 0}};
  return hand;
}

}  // namespace palpate::hand
