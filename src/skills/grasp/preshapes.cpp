// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "palpate/skills/grasp/grasp_phase.hpp"

namespace palpate::skills {

Preshape side_preshape() {
  Preshape preshape{};
  preshape.pitch = 0.197;
  preshape.roll = std::numbers::pi / 2 - 0.017;
  preshape.offset_x = 0.002;
  preshape.height = 0.073;
  preshape.contact_load = 1.0;
  preshape.push = 0.0146;
  preshape.thumb_base = -0.30;
  preshape.thumb_opposition = 1.08;
  preshape.thumb_middle = -0.34;
  preshape.proximal = 0.175;
  preshape.distal = 0.328;
  preshape.spread = 0.18;
  preshape.little_base = 0.1;
  preshape.closing_rate = 1.76;
  preshape.thumb_limit = 0.785;
  preshape.contact_torque = {0.098, 0.069, 0.098, 0.069};
  return preshape;
}

Preshape top_preshape() {
  Preshape preshape{};
  preshape.pitch = 0.475;
  preshape.roll = -0.30;
  preshape.offset_x = -0.005;
  preshape.offset_y = -0.030;
  preshape.contact_load = 1.0;
  preshape.thumb_base = -0.20;
  preshape.thumb_opposition = 1.03;
  preshape.thumb_middle = -0.21;
  preshape.proximal = 0.094;
  preshape.distal = 0.540;
  preshape.spread = 0.087;
  preshape.little_base = 0.1;
  preshape.closing_rate = 0.5;
  preshape.thumb_limit = 0.718;
  preshape.contact_torque = {0.117, 0.082, 0.117, 0.082};
  return preshape;
}

}  // namespace palpate::skills
