// SPDX-License-Identifier: Apache-2.0
#include "train_biotac.hpp"
#include "train_relocate.hpp"

namespace palpate::app {

void add_train(CLI::App& program, Command& chosen) {
  auto& command = *program.add_subcommand("train", "Train a model or a policy");
  command.require_subcommand(1);
  command.footer(
      "Examples:\n"
      "  palpate train relocate --out out/cem --iterations 40\n"
      "  palpate train biotac-normal day1.csv day2.csv --out biotac.model");
  add_train_biotac(command, chosen);
  add_train_relocate(command, chosen);
}

}  // namespace palpate::app
