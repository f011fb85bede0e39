// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <exception>

#include "common.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/unknown_option.hpp"
#include "palpate/core/version.hpp"
#include "usage.hpp"

namespace {

/// Names the command's own option for a key of that name, or the list of options.
int run_command(const CLI::App& program, const palpate::app::Command& chosen) {
  try {
    return chosen();
  } catch (const palpate::UnknownOption& error) {
    const std::string own = "--" + error.key();
    const CLI::App* const command = palpate::app::innermost(&program);
    if (command->get_option_no_throw(own)) {
      throw palpate::BadInput(
          fmt::format("{} is no option of a configuration; {} sets it", error.key(), own));
    }
    const std::string what = error.what();
    if (what.find("did you mean") != what.npos) throw;
    throw palpate::BadInput(what + "; palpate options lists the options of each command");
  }
}

int run(int argc, char** argv) {
  using namespace palpate::app;
  CLI::App program{"Palpate: tactile-only in-hand pose estimation and manipulation.", "palpate"};
  program.set_version_flag("--version", std::string(palpate::version()));
  program.require_subcommand(1);
  program.failure_message(usage_error);
  program.formatter(std::make_shared<HelpFormatter>());
  program.footer(
      "palpate COMMAND --help shows a command's options and examples.\n"
      "Exit codes: 0 done, 2 usage, 3 bad input, 4 no solution, 5 the robot was stopped by a "
      "fault.");
  Command chosen;
  add_pick(program, chosen);
  add_eval(program, chosen);
  add_merge(program, chosen);
  add_replay(program, chosen);
  add_register(program, chosen);
  add_certify(program, chosen);
  add_localize(program, chosen);
  add_plan(program, chosen);
  add_doctor(program, chosen);
  add_render(program, chosen);
  add_bench(program, chosen);
  add_rollout(program, chosen);
  add_compare(program, chosen);
  add_sense(program, chosen);
  add_train(program, chosen);
  add_demos(program, chosen);
  add_view(program, chosen);
  add_hand(program, chosen);
  add_options(program, chosen);
  add_export(program, chosen);
  add_ros2(program, chosen);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? kDone : kUsage;
  }
  return run_command(program, chosen);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const palpate::BadInput& error) {
    fmt::print(stderr, "palpate: {}\n", error.what());
    return palpate::app::kBadInput;
  } catch (const std::exception& error) {
    fmt::print(stderr, "palpate: unexpected failure: {}\n", error.what());
    return 1;
  }
}
