// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "palpate/skills/grasp/grasp_phase.hpp"

namespace palpate::skills {

GraspRecipe side_recipe() {
  GraspRecipe recipe{};
  recipe.pitch = 0.197;
  recipe.roll = std::numbers::pi / 2 - 0.017;
  recipe.offset_x = 0.002;
  recipe.height = 0.073;
  recipe.contact_load = 1.0;
  recipe.push = 0.0146;
  recipe.thumb_base = -0.30;
  recipe.thumb_opposition = 1.08;
  recipe.thumb_middle = -0.34;
  recipe.proximal = 0.175;
  recipe.distal = 0.328;
  recipe.spread = 0.18;
  recipe.little_base = 0.1;
  recipe.closing_rate = 1.76;
  recipe.thumb_limit = 0.785;
  recipe.contact_torque = {0.098, 0.069, 0.098, 0.069};
  return recipe;
}

GraspRecipe top_recipe() {
  GraspRecipe recipe{};
  recipe.pitch = 0.475;
  recipe.roll = -0.30;
  recipe.offset_x = -0.005;
  recipe.offset_y = -0.030;
  recipe.contact_load = 1.0;
  recipe.thumb_base = -0.20;
  recipe.thumb_opposition = 1.03;
  recipe.thumb_middle = -0.21;
  recipe.proximal = 0.094;
  recipe.distal = 0.540;
  recipe.spread = 0.087;
  recipe.little_base = 0.1;
  recipe.closing_rate = 0.5;
  recipe.thumb_limit = 0.718;
  recipe.contact_torque = {0.117, 0.082, 0.117, 0.082};
  return recipe;
}

}  // namespace palpate::skills
