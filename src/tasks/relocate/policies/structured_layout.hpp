// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/tasks/relocate/policies/structured_policy.hpp"

namespace palpate::relocate {

/// Number of all parameters.
Eigen::Index structured_size();

/// Calls visit(name, field) for every parameter, in the order of their vector; the field is
/// an Eigen vector that refers to the parameter.
template <class Parameters, class Visitor>
void for_each_field(Parameters& p, Visitor&& visit) {
  visit("approach_offset", p.approach_offset);
  visit("grasp_offset", p.grasp_offset);
  visit("approach_turn", p.approach_turn);
  visit("grasp_turn", p.grasp_turn);
  visit("carry_turn", p.carry_turn);
  visit("open", p.open);
  visit("closed", p.closed);
  visit("descend", p.descend);
  visit("close", p.close);
  visit("latch", p.latch);
  visit("align", p.align);
  visit("carry_flexion", p.carry_flexion);
  visit("carry_distance", p.carry_distance);
  visit("reach_gains", p.reach_gains);
  visit("carry_gains", p.carry_gains);
  visit("reach_force", p.reach_force);
  visit("carry_force", p.carry_force);
  visit("target_offset", p.target_offset);
  visit("limits", p.limits);
  visit("memory_gain", p.memory_gain);
  visit("memory_center", p.memory_center);
}

}  // namespace palpate::relocate
