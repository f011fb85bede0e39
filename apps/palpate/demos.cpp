// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "common.hpp"
#include "given_command.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/simulation/hand/mjcf_hand.hpp"
#include "palpate/tasks/relocate/minari_io.hpp"
#include "progress_bar.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

constexpr const char* kDatasetId = "palpate/relocate-human-v0";
constexpr std::size_t kTries = 4;  // for each demonstration wanted, at most

struct MakeArguments {
  CommonOptions common;
  std::size_t count = 100;
};

struct MakeOptions {
  relocate::TaskOptions task;
  relocate::DemonstrationOptions demonstration;

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("task", task);
    v.section("demonstration", demonstration);
  }
};

/// Steps of the longest episode.
Eigen::Index longest(const relocate::MinariDataset& dataset) {
  Eigen::Index most = 1;
  for (const auto& episode : dataset.episodes) most = std::max(most, episode.actions.cols());
  return most;
}

int make(const MakeArguments& arguments) {
  const auto& common = arguments.common;
  if (common.out.empty()) throw BadInput("--out DIR is missing: where the data set is to be kept");
  const auto options = resolve<MakeOptions>(common);
  (void)relocate::episode_seed(common.seed, 0);  // refuses what no data set can hold, at once
  const auto output =
      claim_output(common, {"data/metadata.json", "data/main_data.hdf5", "config.toml"});
  const auto model = relocate::make_model(options.task);
  const auto begin = std::chrono::steady_clock::now();
  const auto progress = [&](std::size_t done, std::size_t all) {
    if (!common.quiet) fmt::print(stderr, "kept {} of {}\n", done, all);
  };
  const auto set =
      relocate::make_demonstrations(model, options.demonstration, common.seed, arguments.count,
                                    kTries * arguments.count, common.threads, progress);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (set.kept.empty()) {
    fmt::print(stderr, "palpate: none of {} sequences succeeded on the robot\n", set.tried);
    return kNoSolution;
  }
  if (set.kept.size() < arguments.count) {
    fmt::print(stderr, "palpate: only {} of {} demonstrations: of {} sequences no more succeeded\n",
               set.kept.size(), arguments.count, set.tried);
  }
  const std::filesystem::path folder = common.out;
  auto dataset = relocate::dataset_of(set.kept, kDatasetId, common.seed);
  relocate::EpisodeOptions episode = options.demonstration.episode;
  episode.horizon = static_cast<int>(longest(dataset));
  dataset.env_spec = relocate::environment_spec(options.task, episode);
  relocate::write_minari(folder, dataset);
  write_file_atomically(folder / "config.toml", config_header(common) + to_toml(options));
  std::vector<relocate::Episode> episodes;
  for (const auto& d : set.kept) episodes.push_back(d.episode);
  const auto summary = relocate::summarize(episodes);
  const json report = {
      {"kept", set.kept.size()},
      {"tried", set.tried},
      {"return",
       {{"mean", summary.mean}, {"sd", episodes.size() > 1 ? json(summary.sd) : json(nullptr)}}},
      {"success_2cm", summary.success_2cm},
      {"seconds", seconds}};
  if (common.json) {
    print_json(report);
  } else {
    fmt::print("{} of {} sequences succeeded; return {:.0f} +- {}; {:.0f} s\nwrote {}\n",
               set.kept.size(), set.tried, summary.mean,
               episodes.size() > 1 ? fmt::format("{:.0f}", summary.sd) : "-", seconds,
               folder.string());
    print_next(common, fmt::format("palpate train relocate --method dapg --demos {} --out out/dapg",
                                   quoted(folder.string())));
  }
  return kDone;
}

struct RetargetArguments {
  CommonOptions common;
  std::string keypoints;
  double rate = 30;
};

struct RetargetCommandOptions {
  learning::FilterOptions filter;
  learning::RetargetOptions retarget;

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("filter", filter);
    v.section("retarget", retarget);
  }
};

struct RetargetReport {
  std::size_t frames = 0;
  int replaced = 0;
  double tip_mm = 0, middle_mm = 0, ms = 0, largest_step = 0;
};

std::string joints_header(const hand::PointKinematics& hand) {
  std::string header = "frame";
  for (const auto& name : hand.joint_names()) header += "," + name;
  return header + "\n";
}

int retarget(const RetargetArguments& arguments) {
  const auto& common = arguments.common;
  const auto options = resolve<RetargetCommandOptions>(common);
  const auto filtered = learning::filter_hand(learning::read_keypoints(arguments.keypoints),
                                              arguments.rate, options.filter);
  learning::Retargeter retargeter(
      std::make_unique<simulation::MjcfHand>(asset("adroit_hand/adroit_relocate.xml"), "palm"),
      learning::adroit_points(), options.retarget);
  RetargetReport report{filtered.hand.size(), filtered.replaced, 0, 0, 0, 0};
  std::string table = joints_header(retargeter.hand());
  Eigen::VectorXd before;
  const auto count = static_cast<double>(filtered.hand.size());
  std::optional<ProgressBar> bar(std::in_place, "frames", filtered.hand.size(), common.quiet);
  for (std::size_t i = 0; i < filtered.hand.size(); ++i) {
    bar->show(i);
    const auto begin = std::chrono::steady_clock::now();
    const auto frame = retargeter.next(filtered.hand[i]);
    const auto end = std::chrono::steady_clock::now();
    // The first frame is solved from nothing, many times over.
    if (i > 0) {
      report.ms += std::chrono::duration<double, std::milli>(end - begin).count() / (count - 1);
      report.largest_step =
          std::max(report.largest_step, (frame.joints - before).cwiseAbs().maxCoeff());
    }
    report.tip_mm += 1000 * frame.tip_error / count;
    report.middle_mm += 1000 * frame.middle_error / count;
    before = frame.joints;
    table += fmt::format("{}", i);
    for (const double angle : frame.joints) table += fmt::format(",{:.6f}", angle);
    table += "\n";
  }
  bar.reset();
  if (!common.out.empty()) {
    const auto output = claim_output(common, {"joints.csv"});
    write_file_atomically(std::filesystem::path(common.out) / "joints.csv", table);
  }
  if (common.json) {
    const json out = {{"frames", report.frames},       {"replaced", report.replaced},
                      {"tip_error_mm", report.tip_mm}, {"middle_error_mm", report.middle_mm},
                      {"ms_per_frame", report.ms},     {"largest_step_rad", report.largest_step}};
    print_json(out);
  } else {
    fmt::print(
        "{} frames, {} joints filled in: tips {:.1f} mm, middle joints {:.1f} mm off; {:.2f} ms a "
        "frame; largest step {:.3f} rad\n",
        report.frames, report.replaced, report.tip_mm, report.middle_mm, report.ms,
        report.largest_step);
  }
  return kDone;
}

void add_make(CLI::App& demos, Command& chosen) {
  auto arguments = std::make_shared<MakeArguments>();
  auto& command = *demos.add_subcommand(
      "make", "Generate demonstrations by a synthetic human hand that the robot can repeat");
  command
      .add_option(
          "--count", arguments->count,
          fmt::format("demonstrations to keep; at most {} sequences are tried for each, and "
                      "fewer are kept if too few succeed",
                      kTries))
      ->check(in_range(1, 100000))
      ->capture_default_str();
  add_common_options(command, arguments->common);
  command.footer(
      "DIR/data holds the episodes as the Minari library reads them.\n\n"
      "Examples:\n"
      "  palpate demos make --count 100 --threads 2 --out out/demos\n"
      "  palpate train relocate --method dapg --demos out/demos --out out/dapg");
  command.callback([arguments, &chosen] { chosen = [arguments] { return make(*arguments); }; });
}

void add_retarget(CLI::App& demos, Command& chosen) {
  auto arguments = std::make_shared<RetargetArguments>();
  auto& command = *demos.add_subcommand(
      "retarget", "Retarget the keypoints of a human hand to the Adroit hand");
  command.add_option("KEYPOINTS", arguments->keypoints, "CSV: frame,j0_x,j0_y,j0_z,...,j20_z; m")
      ->required();
  command.add_option("--rate", arguments->rate, "frames per second")
      ->check(in_range(0.1, 1e5))
      ->capture_default_str();
  add_common_options(command, arguments->common, kConfig | kOut);
  command.footer(
      "With --out the joints go to DIR/joints.csv. A joint that was not seen is an empty cell.\n\n"
      "Example:\n"
      "  palpate demos retarget hand_joints.csv --out out/retargeted");
  command.callback([arguments, &chosen] { chosen = [arguments] { return retarget(*arguments); }; });
}

}  // namespace

std::vector<OptionInfo> demos_make_option_list() { return list_options(MakeOptions{}); }
std::vector<OptionInfo> demos_retarget_option_list() {
  return list_options(RetargetCommandOptions{});
}

void add_demos(CLI::App& program, Command& chosen) {
  auto& command = *program.add_subcommand("demos", "Make demonstrations of the relocate task");
  command.require_subcommand(1);
  command.footer(
      "Examples:\n"
      "  palpate demos make --count 100 --threads 2 --out out/demos\n"
      "  palpate demos retarget hand_joints.csv");
  add_make(command, chosen);
  add_retarget(command, chosen);
}

}  // namespace palpate::app
