// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/rollout.hpp"

#include <fmt/format.h>

#include <chrono>

#include "common.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/learning/episode_recording.hpp"
#include "palpate/recording/writer.hpp"
#include "relocate_arguments.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

struct RolloutArguments {
  CommonOptions common;
  std::string policy;
  std::size_t episodes = 100, record = 0;
};

/// Runs the first episodes again and keeps what they look like.
void write_recordings(const RolloutArguments& arguments, const RelocateOptions& options,
                      const learning::Policy& policy) {
  const auto& common = arguments.common;
  for (std::size_t i = 0; i < std::min(arguments.record, arguments.episodes); ++i) {
    auto recording =
        learning::record_episode(options.task, policy, options.episode, common.seed, i);
    recording.header.config_toml = config_header(common) + to_toml(options);
    recording::write_recording(std::filesystem::path(common.out) / fmt::format("episode-{}.h5", i),
                               recording);
  }
}

void write_results(const RolloutArguments& arguments, const RelocateOptions& options,
                   const std::vector<learning::Episode>& episodes, const json& report) {
  const std::filesystem::path folder = arguments.common.out;
  write_file_atomically(folder / "episodes.csv", episodes_csv(episodes));
  write_file_atomically(folder / "rollout.json", report.dump(2) + "\n");
  write_file_atomically(folder / "config.toml", config_header(arguments.common) + to_toml(options));
}

void print_table(const learning::RolloutSummary& s, double steps_per_second) {
  fmt::print("return      {:.0f} +- {:.0f}, mean within [{:.0f}, {:.0f}] (95 %)\n", s.mean, s.sd,
             s.ci95.low, s.ci95.high);
  fmt::print(
      "final       {:.3f} within 10 cm, {:.3f} within 5 cm, {:.3f} within 2 cm; median "
      "{:.1f} mm\n",
      s.success_10cm, s.success_5cm, s.success_2cm, 1000 * s.median_distance);
  fmt::print("steady      {:.3f} more than 25 steps within 5 cm\n", s.success_steady);
  fmt::print("episodes    {}, {} diverged; {:.0f} steps/s\n", s.episodes, s.diverged,
             steps_per_second);
}

int rollout(const RolloutArguments& arguments) {
  const auto& common = arguments.common;
  if (arguments.record > 0 && common.out.empty()) {
    throw BadInput("--record needs --out DIR: where the recordings are to go");
  }
  const auto options = resolve<RelocateOptions>(common);
  const auto policy = find_policy(arguments.policy);
  const auto model = learning::make_model(options.task);
  if (!common.out.empty()) make_writable_folder(common.out);

  const auto start = std::chrono::steady_clock::now();
  const auto episodes = learning::rollout(model, *policy, options.episode, common.seed,
                                          arguments.episodes, common.threads);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  double steps = 0;
  for (const auto& episode : episodes) steps += episode.steps;

  const auto summary = learning::summarize(episodes);
  json report = summary_json(summary);
  report["steps_per_second"] = steps / seconds;
  if (!common.out.empty()) write_results(arguments, options, episodes, report);
  write_recordings(arguments, options, *policy);
  if (common.json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    print_table(summary, steps / seconds);
  }
  return kDone;
}

}  // namespace

void add_rollout(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<RolloutArguments>();
  auto& command = *program.add_subcommand("rollout", "Let a policy relocate an object, many times");
  command.add_option("policy", arguments->policy,
                     "policy file or name of a shipped one; without it the best that ships");
  command
      .add_option("--episodes", arguments->episodes,
                  "episodes; number i starts the same for "
                  "every policy")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command
      .add_option("--record", arguments->record,
                  "of the first episodes to keep as DIR/episode-N.h5, for view and render")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  add_common_options(command, arguments->common);
  command.footer(
      "The hand brings a mug from the table to a target in the air within 99 steps of 10 ms.\n"
      "With --out every episode goes to DIR/episodes.csv, which palpate compare reads. A "
      "recording\n"
      "shows the hand as the Shadow hand, which the task's Adroit hand is a model of.\n\n"
      "Examples:\n"
      "  palpate rollout --episodes 20 --threads 2\n"
      "  palpate rollout relocate-best --set episode.scale_high=1 --json\n"
      "  palpate rollout --episodes 3 --record 3 --out out/rollout\n"
      "  palpate rollout --set task.object=box --set task.friction_scale=0.7");
  command.callback([arguments, &chosen] { chosen = [arguments] { return rollout(*arguments); }; });
}

}  // namespace palpate::app
