// SPDX-License-Identifier: Apache-2.0
#include "common.hpp"

#include <fmt/format.h>

#include "palpate/core/se3.hpp"
#include "palpate/core/version.hpp"

namespace palpate::app {

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.add_option("--config", options.config, "TOML file with options")->option_text("FILE");
  command.add_option("--set", options.set, "set one option, e.g. --set lift.way=0.15")
      ->option_text("KEY=VALUE")
      ->allow_extra_args(false);  // else it would take the positional arguments that follow
  command.add_option("--seed", options.seed, "seed of all randomness")->capture_default_str();
  command
      .add_option("--threads", options.threads, "threads; the results are the same for any number")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command.add_option("--out", options.out, "folder for the results")->option_text("DIR");
  command.add_flag("--json", options.json, "print one JSON object on stdout");
  command.add_flag("--quiet", options.quiet, "no progress on stderr");
}

std::string config_header(const CommonOptions& common) {
  return fmt::format("# palpate {}, seed {}\n", version(), common.seed);
}

nlohmann::json to_json(const Eigen::Isometry3d& T) { return pose_to_row_major(T); }

}  // namespace palpate::app
