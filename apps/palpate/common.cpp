// SPDX-License-Identifier: Apache-2.0
#include "common.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <limits>
#include <sstream>

#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/core/version.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::app {

namespace {

void add_config(CLI::App& command, CommonOptions& options) {
  command.add_option("--config", options.config, "TOML file with options")->option_text("FILE");
  command
      .add_option("--set", options.set,
                  fmt::format("set one option of those that `palpate options {}` lists",
                              words_of(&command)))
      ->option_text("KEY=VALUE")
      ->allow_extra_args(false);  // else it would take the positional arguments that follow
}

void add_seed(CLI::App& command, CommonOptions& options) {
  command.add_option("--seed", options.seed, "seed of all randomness")
      ->check(at_least(0))
      ->capture_default_str();
}

void add_threads(CLI::App& command, CommonOptions& options) {
  command
      .add_option("--threads", options.threads, "threads; the results are the same for any number")
      ->check(in_range(1, 1024))
      ->capture_default_str();
}

void add_out(CLI::App& command, CommonOptions& options) {
  command.add_option("--out", options.out, "folder for the results")->option_text("DIR");
  command.add_flag("--force", options.force, "overwrite the results that are in DIR");
}

}  // namespace

void add_common_options(CLI::App& command, CommonOptions& options, unsigned uses) {
  if (uses & kConfig) add_config(command, options);
  if (uses & kSeed) add_seed(command, options);
  if (uses & kThreads) add_threads(command, options);
  if (uses & kOut) add_out(command, options);
  command.add_flag("--json", options.json, "print one JSON object on stdout");
  command.add_flag("--quiet", options.quiet, "no progress on stderr");
}

void accept_folder_of_pick(CLI::Option& option) {
  option.transform([](const std::string& given) {
    const auto inside = std::filesystem::path(given) / "recording.h5";
    std::error_code error;
    const auto is_there = [&error](const std::filesystem::path& path) {
      return std::filesystem::is_regular_file(path, error);
    };
    // Of a pick that was interrupted there is a part, which reading names.
    const bool is_pick = is_there(inside) || is_there(inside.string() + ".partial");
    return is_pick ? inside.string() : given;
  });
}

std::unique_ptr<OutputFolder> claim_output(const CommonOptions& common,
                                           const std::vector<std::string>& results) {
  if (common.out.empty()) return nullptr;
  return std::make_unique<OutputFolder>(common.out, results, common.force);
}

std::string config_header(const CommonOptions& common) {
  return fmt::format("# palpate {}, MuJoCo {}, seed {}\n", version(),
                     simulation::simulator_version(), common.seed);
}

Eigen::Isometry3d parse_pose(const std::string& argument) {
  std::string text = argument;
  std::error_code error;
  const bool is_file = std::filesystem::exists(argument, error) &&
                       !std::filesystem::is_directory(argument, error);  // a pipe, too
  if (is_file) text = without_byte_order_mark(read_file(argument));
  for (char& c : text) c = c == ',' || c == '[' || c == ']' ? ' ' : c;
  std::istringstream in(text);
  std::array<double, 16> values{};
  std::size_t count = 0;
  for (double value; in >> value; ++count) {
    if (count < values.size()) values[count] = value;
  }
  if (count != values.size() || !in.eof()) {
    throw BadInput(fmt::format("'{}' {} 16 numbers, row-major", argument,
                               is_file ? "does not hold" : "is neither a file nor"));
  }
  try {
    const Eigen::Isometry3d T = pose_from_row_major(values);
    check_plausible(T.translation(), kMaxCoordinate, "a coordinate");
    return T;
  } catch (const BadInput& bad) {
    throw BadInput(fmt::format("{}: {}", argument, bad.what()));
  }
}

nlohmann::json to_json(const Eigen::Isometry3d& T) { return pose_to_row_major(T); }

std::string json_text(const nlohmann::json& value, int indent) {
  return value.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

void print_json(const nlohmann::json& value) { fmt::print("{}", json_text(value)); }

}  // namespace palpate::app
