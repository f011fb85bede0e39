// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "common.hpp"

namespace palpate::app {

constexpr int kIterations = 40;
constexpr std::size_t kDemonstrations = 25;

/// What `palpate train relocate` is given.
struct TrainArguments {
  CommonOptions common;
  std::string method = "cem";
  std::string from, expert, demos;
  std::optional<int> iterations;              // none: kIterations
  std::optional<std::size_t> demonstrations;  // none: kDemonstrations
  std::size_t episodes = 30;
  bool ask = false, tell = false;  // by files, for other machines
  std::string score;               // the share that this one runs of what was asked for

  [[nodiscard]] bool by_rounds() const { return ask || tell || !score.empty(); }
  /// Whether --iterations is of the method: cem, npg, dapg.
  [[nodiscard]] bool counts_iterations() const { return method != "bc" && method != "dagger"; }
};

}  // namespace palpate::app
