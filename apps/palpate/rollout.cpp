// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/rollout.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common.hpp"
#include "given_command.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/recording/writer.hpp"
#include "palpate/tasks/relocate/episode_recording.hpp"
#include "palpate/tasks/relocate/relocation.hpp"
#include "progress_bar.hpp"
#include "relocate_arguments.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

struct RolloutArguments {
  CommonOptions common;
  std::string policy;
  std::size_t episodes = 100, record = 0;
  bool touch = false;
};

/// The episodes, and the estimates by touch in them, if the policy was given those.
struct Rollout {
  std::vector<relocate::Episode> episodes;
  std::vector<relocate::TouchEpisode> by_touch;
};

/// Runs episodes: the policy is given the truth, or estimates by touch.
class Runner {
 public:
  Runner(const RolloutArguments& arguments, const RolloutOptions& options)
      : arguments_(arguments), options_(options) {
    if (arguments.touch) relocate::check_by_touch(options.episode);
    static_cast<void>(relocate::episode_start(options.episode, arguments.common.seed, 0));
    if (arguments.touch) {
      relocation_.emplace(options.task, options.touch);
    } else {
      model_.emplace(relocate::make_model(options.task));
    }
  }

  [[nodiscard]] Rollout run(const relocate::Policy& policy) const {
    const auto& common = arguments_.common;
    Rollout result;
    if (model_) {
      const Notice notice("running episodes", common.quiet);
      result.episodes = relocate::rollout(*model_, policy, options_.episode, common.seed,
                                          arguments_.episodes, common.threads);
      return result;
    }
    const ProgressBar bar("relocate", arguments_.episodes, common.quiet);
    bar.show(0);
    result.by_touch = relocation_->run_all(
        policy, options_.episode, common.seed, arguments_.episodes, common.threads,
        [&bar](std::size_t done, std::size_t) { bar.show(done); });
    for (const auto& one : result.by_touch) result.episodes.push_back(one.episode);
    return result;
  }

  /// Runs an episode again to keep what it looks like.
  [[nodiscard]] recording::Recording record(const relocate::Policy& policy,
                                            std::size_t index) const {
    const std::uint64_t seed = arguments_.common.seed;
    if (model_) {
      return relocate::record_episode(options_.task, policy, options_.episode, seed, index);
    }
    recording::Recording recording;
    relocation_->run(policy, options_.episode, seed, index, &recording);
    return recording;
  }

 private:
  const RolloutArguments& arguments_;
  const RolloutOptions& options_;
  std::optional<relocate::RelocateModel> model_;
  std::optional<relocate::Relocation> relocation_;
};

template <class Value>
double median_of(const std::vector<relocate::TouchEpisode>& by_touch,
                 Value relocate::TouchEpisode::*value) {
  std::vector<double> values;
  for (const auto& episode : by_touch) values.push_back(static_cast<double>(episode.*value));
  return median(values);
}

std::string config_text(const RolloutArguments& arguments, const RolloutOptions& options) {
  const RelocateOptions& given_the_truth = options;
  return config_header(arguments.common) +
         (arguments.touch ? to_toml(options) : to_toml(given_the_truth));
}

void write_recordings(const RolloutArguments& arguments, const RolloutOptions& options,
                      const Runner& runner, const relocate::Policy& policy) {
  const std::size_t count = std::min(arguments.record, arguments.episodes);
  const ProgressBar bar("record", count, arguments.common.quiet || count == 0);
  for (std::size_t i = 0; i < count; ++i) {
    auto recording = runner.record(policy, i);
    recording.header.config_toml = config_text(arguments, options);
    const std::filesystem::path folder = arguments.common.out;
    recording::write_recording(folder / fmt::format("episode-{}.h5", i), recording);
    bar.show(i + 1);
  }
}

void write_results(const RolloutArguments& arguments, const RolloutOptions& options,
                   const std::vector<relocate::Episode>& episodes, const json& report) {
  const std::filesystem::path folder = arguments.common.out;
  write_file_atomically(folder / "episodes.csv", episodes_csv(episodes));
  write_file_atomically(folder / "rollout.json", json_text(report));
  write_file_atomically(folder / "config.toml", config_text(arguments, options));
}

/// One episode has no spread: "-".
void print_return(const relocate::RolloutSummary& s) {
  if (!s.ci95) {
    fmt::print("return      {:.0f} +- -, mean within - (95 %)\n", s.mean);
    return;
  }
  fmt::print("return      {:.0f} +- {:.0f}, mean within [{:.0f}, {:.0f}] (95 %)\n", s.mean, s.sd,
             s.ci95->low, s.ci95->high);
}

void print_table(const relocate::RolloutSummary& s, double steps_per_second,
                 const std::vector<std::string>& observed) {
  print_return(s);
  fmt::print(
      "final       {:.3f} within 10 cm, {:.3f} within 5 cm, {:.3f} within 2 cm; median "
      "{:.1f} mm\n",
      s.success_10cm, s.success_5cm, s.success_2cm, 1000 * s.median_distance);
  fmt::print("steady      {:.3f} more than 25 steps within 5 cm\n", s.success_steady);
  fmt::print("episodes    {}, {} diverged; {:.0f} steps/s\n", s.episodes, s.diverged,
             steps_per_second);
  fmt::print("observes    {}\n", fmt::join(observed, ", "));
}

json touch_json(const std::vector<relocate::TouchEpisode>& by_touch) {
  using relocate::TouchEpisode;
  double estimates = 0, seconds = 0;
  for (const auto& episode : by_touch) {
    estimates += episode.estimates;
    seconds += episode.estimates * episode.estimate_seconds;
  }
  return {{"explored", std::ranges::count_if(by_touch, &TouchEpisode::explored)},
          {"explore_seconds", hand::kTick * median_of(by_touch, &TouchEpisode::explore_steps)},
          {"resting_error_mm", 1e3 * median_of(by_touch, &TouchEpisode::resting_error)},
          {"reported_error_mm", 1e3 * median_of(by_touch, &TouchEpisode::reported_error)},
          {"estimates", estimates / static_cast<double>(by_touch.size())},
          {"estimate_seconds", estimates > 0 ? json(seconds / estimates) : json(nullptr)}};
}

void print_touch(const std::vector<relocate::TouchEpisode>& by_touch) {
  const json touch = touch_json(by_touch);
  const auto failed = std::ranges::find(by_touch, false, &relocate::TouchEpisode::explored);
  if (failed != by_touch.end() && !failed->exploration.empty()) {
    fmt::print("unexplored  {} of {}, the first because: {}\n",
               std::ranges::count(by_touch, false, &relocate::TouchEpisode::explored),
               by_touch.size(), failed->exploration);
  }
  fmt::print(
      "by touch    {} explored, in {:.0f} s; place reported {:.1f} mm off at first (in x and y), "
      "{:.1f} mm at the end (medians); {:.1f} estimates in the grasp\n",
      touch["explored"].get<int>(), touch["explore_seconds"].get<double>(),
      touch["resting_error_mm"].get<double>(), touch["reported_error_mm"].get<double>(),
      touch["estimates"].get<double>());
}

/// What the policy observes, as reported.
std::vector<std::string> observes(const relocate::Policy& policy, bool by_touch) {
  auto names = policy.observes();
  if (by_touch) {
    std::ranges::replace(names, std::string("object_position"), "object_position_by_touch");
  }
  return names;
}

/// Where the episodes are seen, or compared with others.
void print_next_of(const RolloutArguments& arguments, const CLI::App& command) {
  const CommonOptions& common = arguments.common;
  if (arguments.record > 0) {
    print_next(common, "palpate view " + quoted(common.out + "/episode-0.h5"));
  } else if (!common.out.empty()) {
    print_next(common, fmt::format("palpate compare {} relocate-best",
                                   quoted(common.out + "/episodes.csv")));
  } else {
    print_next(common, given_command(command) +
                           " --record 1 --out out/rollout records an episode for palpate view");
  }
}

/// Whether it is the name of a recording: episode-N.h5.
bool is_recording(std::string_view name) {
  constexpr std::string_view kStart = "episode-", kEnd = ".h5";
  if (!name.starts_with(kStart) || !name.ends_with(kEnd)) return false;
  name.remove_prefix(kStart.size());
  name.remove_suffix(std::min(kEnd.size(), name.size()));
  return !name.empty() && name.find_first_not_of("0123456789") == name.npos;
}

/// What a rollout writes; with --force also the recordings of an earlier one, which go with it.
std::vector<std::string> result_names(const RolloutArguments& arguments) {
  const auto& common = arguments.common;
  std::vector<std::string> names = {"rollout.json", "episodes.csv", "config.toml"};
  for (std::size_t i = 0; i < std::min(arguments.record, arguments.episodes); ++i) {
    names.push_back(fmt::format("episode-{}.h5", i));
  }
  if (!common.force) return names;
  std::error_code none;  // a folder that is not there yet has no entries
  for (const auto& entry : std::filesystem::directory_iterator(common.out, none)) {
    const std::string name = entry.path().filename().string();
    if (is_recording(name)) names.push_back(name);
  }
  return names;
}

int rollout(const RolloutArguments& arguments, const CLI::App& command) {
  const auto& common = arguments.common;
  if (arguments.record > 0 && common.out.empty()) {
    throw BadInput("--record needs --out DIR: where the recordings are to go");
  }
  const auto options = resolve<RolloutOptions>(common);
  const auto policy = find_policy(arguments.policy);
  const Runner runner(arguments, options);  // what cannot be run is said before a folder is made
  const auto output = claim_output(common, result_names(arguments));

  const auto start = std::chrono::steady_clock::now();
  const auto [episodes, by_touch] = runner.run(*policy);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  double steps = 0;
  for (const auto& episode : episodes) steps += episode.steps;

  const auto summary = relocate::summarize(episodes);
  json report = summary_json(summary);
  report["steps_per_second"] = steps / seconds;
  report["observes"] = observes(*policy, arguments.touch);
  if (arguments.touch) report["touch"] = touch_json(by_touch);
  if (!common.out.empty()) write_results(arguments, options, episodes, report);
  write_recordings(arguments, options, runner, *policy);
  if (common.json) {
    print_json(report);
  } else {
    print_table(summary, steps / seconds, observes(*policy, arguments.touch));
    if (arguments.touch) print_touch(by_touch);
    print_next_of(arguments, command);
  }
  return kDone;
}

}  // namespace

std::vector<OptionInfo> rollout_option_list() { return list_options(RolloutOptions{}); }

void add_rollout(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<RolloutArguments>();
  auto& command = *program.add_subcommand(
      "rollout", "Run a policy on the relocate task and report its return and success");
  command.add_option("policy", arguments->policy,
                     "policy file, or name of a shipped policy (default: relocate-best)");
  command
      .add_option("--episodes", arguments->episodes,
                  "episodes; number i starts the same for "
                  "every policy")
      ->check(in_range(1, 1000000))
      ->capture_default_str();
  command
      .add_option("--record", arguments->record,
                  "number of first episodes to record as DIR/episode-N.h5, for view and render")
      ->check(in_range(0, 1000))
      ->capture_default_str();
  command.add_flag("--touch", arguments->touch,
                   "give the policy the pose estimated by touch instead of the true one");
  add_task_option(command);
  add_common_options(command, arguments->common);
  command.footer(
      "The hand brings a mug from the table to a target in the air within 99 steps of 10 ms.\n"
      "With --touch the hand first explores the resting object with a finger, and its fingertips\n"
      "track the object in the grasp (options touch.*); that takes some 20 seconds per episode.\n"
      "With --out every episode goes to DIR/episodes.csv, which palpate compare reads. A "
      "recording\n"
      "shows the Shadow hand, of which the Adroit hand of the task is a model. A recording by "
      "touch\n"
      "is of the Adroit hand and what it senses; palpate replay estimates from it again.\n\n"
      "Examples:\n"
      "  palpate rollout --task relocate-v2 --episodes 20 --threads 2\n"
      "  palpate rollout relocate-best --set episode.scale_high=1 --json\n"
      "  palpate rollout --episodes 3 --record 3 --out out/rollout\n"
      "  palpate rollout --touch --episodes 10\n"
      "  palpate rollout --set task.object=box --set task.friction_scale=0.7");
  command.callback([arguments, &command, &chosen] {
    chosen = [arguments, &command] { return rollout(*arguments, command); };
  });
}

}  // namespace palpate::app
