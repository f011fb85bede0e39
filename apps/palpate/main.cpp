// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "program.hpp"

int main(int argc, char** argv) {
  using namespace palpate::app;
  const std::array commands = {
      add_pick,  add_eval,   add_merge,  add_replay, add_register, add_certify, add_localize,
      add_plan,  add_doctor, add_render, add_bench,  add_rollout,  add_compare, add_sense,
      add_train, add_demos,  add_view,   add_hand,   add_options,  add_export,  add_ros2};
  return run_program(commands, argc, argv);
}
