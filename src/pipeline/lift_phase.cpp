// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/lift_phase.hpp"

#include <fmt/format.h>

namespace palpate::pipeline {
namespace {

double mean_load(const TouchLog& log, std::size_t readings) {
  double sum = 0;
  for (std::size_t i = log.readings.size() - readings; i < log.readings.size(); ++i) {
    sum += log.readings[i].base_force.z();
  }
  return sum / static_cast<double>(readings);
}

}  // namespace

PhaseEnd LiftPhase::run(Robot& robot, PickState& state) {
  hand::BasePosition up = robot.command().base;
  up.xyz.z() += options_.way;
  robot.move_base(up, options_.speed);
  robot.wait(options_.settle);
  robot.wait(options_.hold);
  robot.mark(Mark::held);
  state.held_load = mean_load(robot.log(), 50);
  const bool held = state.held_load > options_.least_weight * weight_;
  return {held, fmt::format("{}: {:.2f} N of {:.2f} N hang in the hand", held ? "held" : "lost",
                            state.held_load, weight_)};
}

}  // namespace palpate::pipeline
