// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <numbers>
#include <optional>

#include "common.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/evaluation/recorder.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/recording/touch_log.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

struct ReplayArguments {
  CommonOptions common;
  std::string recording;
};

/// Options of the recording, changed by --config and --set.
/// @throws BadInput for another source of contacts, for the recording holds those of its own
evaluation::TrialOptions replay_options(const recording::Recording& recording,
                                        const CommonOptions& common, const std::string& name) {
  evaluation::TrialOptions options;
  parse_toml(recording.header.config_toml, name, options, Renamed::accepted);
  const std::string recorded = options.touch.source;
  if (!common.config.empty()) load_toml(common.config, options);
  for (const auto& assignment : common.set) apply_setting(assignment, options);
  if (options.touch.source != recorded) {
    throw BadInput(fmt::format("touch.source = {:?}: {} holds the contacts of {:?}",
                               options.touch.source, name, recorded));
  }
  return options;
}

nlohmann::json posterior_json(const localization::Posterior& posterior) {
  auto modes = nlohmann::json::array();
  for (const auto& mode : posterior.modes) {
    modes.push_back({{"T_world_object", to_json(mode.T_frame_object)},
                     {"weight", mode.weight},
                     {"probability", localization::pose_probability(mode)}});
  }
  return {{"status", localization::to_string(posterior.status)}, {"modes", modes}};
}

int replay(const ReplayArguments& arguments) {
  std::optional<Notice> notice(std::in_place, "estimating", arguments.common.quiet);
  const auto recording = recording::read_recording(arguments.recording);
  const auto options = replay_options(recording, arguments.common, arguments.recording);
  const geometry::ObjectModel object(recording.header.object);
  auto log = recording::event_log(recording).until(estimation::TouchEvent::held);
  const auto [hand, T_world_table] =
      skills::calibration(recording.header.hand, log, options.pick.calibrate);
  log.T_world_table = Eigen::Isometry3d(T_world_table.linear());
  const auto estimate =
      estimation::PoseEstimator(object, options.pick_options().estimation, recording.header.seed)
          .held(hand, log, log.at(estimation::TouchEvent::held));
  const auto& posterior = estimate.posterior;
  notice.reset();
  if (arguments.common.json) {
    fmt::print("{}\n", posterior_json(posterior).dump(2));
  } else {
    fmt::print("{}, {} contacts, {:.2f} s\n",
               colored_status(localization::to_string(posterior.status)), estimate.contacts.size(),
               posterior.seconds);
    for (const auto& mode : posterior.modes) {
      const auto& p = mode.T_frame_object.translation();
      fmt::print("  probability {:.3f} at ({:.1f}, {:.1f}, {:.1f}) mm\n",
                 localization::pose_probability(mode), 1e3 * p.x(), 1e3 * p.y(), 1e3 * p.z());
    }
  }
  return posterior.modes.empty() ? kNoSolution : kDone;
}

}  // namespace

void add_replay(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<ReplayArguments>();
  auto& command = *program.add_subcommand(
      "replay", "Estimate the pose again from a recording, without the simulator");
  command.add_option("recording", arguments->recording, "recording.h5 of a pick")->required();
  add_common_options(command, arguments->common, kConfig);
  command.footer(
      "Uses the recording's own configuration and seed, so that it gives the pose that the pick\n"
      "gave, bit for bit; --set changes the estimator's options.\n\n"
      "Examples:\n"
      "  palpate replay out/pick-mug-7/recording.h5\n"
      "  palpate replay out/pick-mug-7/recording.h5 --set estimation.free_space=false --json");
  command.callback([arguments, &chosen] { chosen = [arguments] { return replay(*arguments); }; });
}

}  // namespace palpate::app
