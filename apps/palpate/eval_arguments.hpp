// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "common.hpp"
#include "live_view.hpp"
#include "object_option.hpp"

namespace palpate::app {

/// A share of all trials, by their number over all objects.
struct Shard {
  std::size_t number = 1, count = 1;

  [[nodiscard]] bool has(std::size_t trial) const { return trial % count == number - 1; }
};

/// What `palpate eval` is given.
struct EvalArguments {
  CommonOptions common;
  bool resume = false;
  std::vector<std::string> objects = {"mug", "bottle", "box", "bracket", "duck"};
  std::size_t trials = 30;
  std::vector<std::string> candidates;
  ObjectArguments known;
  std::string place, hand, arm;
  std::vector<std::string> faults;
  CLI::Option* fault_option = nullptr;
  std::string shard_text;
  Shard shard;
  LiveOption live;

  /// Whether the picks are repeated with faults of the hand.
  [[nodiscard]] bool campaign() const { return fault_option->count() > 0; }
};

void add_eval_arguments(CLI::App& command, EvalArguments& arguments);

/// Reads the share, and expands names that stand for several objects.
/// @throws BadInput for arguments that do not go together
void complete(EvalArguments& arguments);

}  // namespace palpate::app
