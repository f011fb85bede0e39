// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "palpate/core/options.hpp"
#include "palpate/core/output_folder.hpp"
#include "usage.hpp"

namespace palpate::app {

/// Exit codes of the program.
enum ExitCode { kDone = 0, kUsage = 2, kBadInput = 3, kNoSolution = 4, kStopped = 5 };

/// Options that commands share.
struct CommonOptions {
  std::string config;
  std::vector<std::string> set;
  std::uint64_t seed = 0;
  int threads = 1;
  std::string out;
  bool force = false;
  bool json = false;
  bool quiet = false;
};

/// Those of them that a command uses; it refuses the others. --json and --quiet are of all.
enum Uses : unsigned { kConfig = 1, kSeed = 2, kThreads = 4, kOut = 8, kAllCommon = 15 };

void add_common_options(CLI::App& command, CommonOptions& options, unsigned uses = kAllCommon);

/// The folder that a pick wrote stands for the recording in it, as the value of this option.
void accept_folder_of_pick(CLI::Option& option);

/// The folder for the results, if one was asked for: locked, and without these results.
/// @throws BadInput as OutputFolder does
std::unique_ptr<OutputFolder> claim_output(const CommonOptions& common,
                                           const std::vector<std::string>& results);

/// Options struct with the config file and then every --set applied.
template <class Options>
Options resolve(const CommonOptions& common) {
  Options options;
  if (!common.config.empty()) load_toml(common.config, options);
  for (const auto& assignment : common.set) apply_setting(assignment, options);
  return options;
}

/// Text of the resolved configuration, with the seed and the versions that made the result.
std::string config_header(const CommonOptions& common);

nlohmann::json to_json(const Eigen::Isometry3d& T);

/// JSON as the program prints and writes it, with a newline at its end. Bytes that are not UTF-8,
/// as a file's name may have, become U+FFFD.
/// @param indent  columns a level; -1: all in one line
std::string json_text(const nlohmann::json& value, int indent = 2);

/// The one JSON object that --json asks for, on stdout.
void print_json(const nlohmann::json& value);

/// Pose of 16 numbers, row-major, separated by commas or blanks, from the argument itself or the
/// file that it names. @throws BadInput unless it is a pose
Eigen::Isometry3d parse_pose(const std::string& argument);

/// A command adds itself to the program and returns its exit code when it was chosen.
using Command = std::function<int()>;
void add_pick(CLI::App& program, Command& chosen);
void add_eval(CLI::App& program, Command& chosen);
void add_merge(CLI::App& program, Command& chosen);
void add_replay(CLI::App& program, Command& chosen);
void add_register(CLI::App& program, Command& chosen);
void add_certify(CLI::App& program, Command& chosen);
void add_localize(CLI::App& program, Command& chosen);
void add_plan(CLI::App& program, Command& chosen);
void add_doctor(CLI::App& program, Command& chosen);
void add_render(CLI::App& program, Command& chosen);
void add_demos(CLI::App& program, Command& chosen);
void add_bench(CLI::App& program, Command& chosen);
void add_rollout(CLI::App& program, Command& chosen);
void add_compare(CLI::App& program, Command& chosen);
void add_sense(CLI::App& program, Command& chosen);
void add_train(CLI::App& program, Command& chosen);
void add_view(CLI::App& program, Command& chosen);
void add_hand(CLI::App& program, Command& chosen);
void add_options(CLI::App& program, Command& chosen);
void add_export(CLI::App& program, Command& chosen);
void add_ros2(CLI::App& program, Command& chosen);

/// The options that a command's --config and --set can set, at their defaults.
std::vector<OptionInfo> pick_option_list();
std::vector<OptionInfo> replay_option_list();
std::vector<OptionInfo> localize_option_list();
std::vector<OptionInfo> plan_option_list();
std::vector<OptionInfo> register_option_list();
std::vector<OptionInfo> rollout_option_list();
std::vector<OptionInfo> compare_option_list();
std::vector<OptionInfo> demos_make_option_list();
std::vector<OptionInfo> demos_retarget_option_list();
std::vector<OptionInfo> ros2_estimate_option_list();

}  // namespace palpate::app
