// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <numbers>
#include <optional>

#include "common.hpp"
#include "object_option.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/evaluation/recorder.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/recording/touch_log.hpp"
#include "palpate/ros2/read_bag.hpp"
#include "palpate/tasks/relocate/episode_recording.hpp"
#include "relocate_arguments.hpp"
#include "replay_bag.hpp"
#include "replay_options.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

constexpr std::string_view kTracking = "touch.tracking.", kResting = "touch.resting.";

struct ReplayArguments {
  CommonOptions common;
  std::string recording;
  BagArguments bag;
};

/// An estimate, and what it is from.
struct Replayed {
  estimation::HeldPoseEstimate estimate;
  std::uint64_t messages = 0;
  std::string hint;          ///< why there is no pose, where that is known
  std::string weighed = {};  ///< what the pick weighed instead of the object of the pose
  std::string about = {};    ///< a line for a person, before the estimate
};

/// The rest of the comment of the configuration that begins so; empty without.
std::string comment_of(const std::string& config, const std::string& begin) {
  const std::string start = "\n# " + begin + " ";
  const std::size_t at = config.find(start);
  if (at == std::string::npos) return "";
  const std::size_t from = at + start.size();
  return config.substr(from, config.find('\n', from) - from);
}

/// The candidates of the pick, where they were more or others than the object of the recording.
std::string weighed_by_pick(const recording::RecordingHeader& header) {
  const std::string names = comment_of(header.config_toml, "object");
  const std::string truth = comment_of(header.config_toml, "true object");
  const std::string range = comment_of(header.config_toml, "size range");
  const std::string shape = geometry::sized_name(names).name;
  const bool several = names.find(',') != std::string::npos || !range.empty();
  const bool of_it =
      header.object.name == shape || header.object.name == std::filesystem::path(shape).stem();
  const bool of_another_file = !truth.empty() && !is_same_object(names, truth);
  if (!several && of_it && !of_another_file) return "";
  return range.empty() ? names : fmt::format("{} with --size-range {}", names, range);
}

/// Options of the recording, changed by --config and --set.
/// @throws BadInput for another value of what a replay does not read
evaluation::TrialOptions replay_options(const recording::Recording& recording,
                                        const CommonOptions& common, const std::string& name) {
  evaluation::TrialOptions options;
  parse_toml(recording.header.config_toml, name, options, Earlier::accepted);
  const evaluation::TrialOptions recorded = options;
  if (!common.config.empty()) load_toml(common.config, options);
  for (const auto& assignment : common.set) apply_setting(assignment, options);
  refuse_what_is_recorded(recorded, options, name);
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

/// Where a recording ends in which nothing was ever held.
std::string end_of(const recording::Recording& recording) {
  std::string phase, how = "unfinished";
  for (const auto& event : recording.events) {
    if (event.kind == recording::EventKind::note) continue;
    phase = event.phase;
    how = event.kind == recording::EventKind::end ? event.text : "unfinished";
  }
  if (phase.empty()) return "the recording has no phase; nothing was held";
  return fmt::format("the recording ends in phase {} ({}); nothing was held", phase, how);
}

bool is_of_estimates(std::string_view key) {
  if (key.starts_with(kExpertSection)) key.remove_prefix(kExpertSection.size());
  return key.starts_with(kTracking) || key.starts_with(kResting);
}

/// Options of the estimates of an episode, changed by --config and --set.
/// @throws BadInput for another value of what a replay does not read
relocate::RelocationOptions episode_options(const recording::Recording& recording,
                                            const CommonOptions& common, const std::string& name) {
  RolloutOptions options;
  parse_toml(recording.header.config_toml, name, options, Earlier::accepted);
  const auto recorded = list_options(options);
  if (!common.config.empty()) load_toml(common.config, options);
  for (const auto& assignment : common.set) apply_setting(assignment, options);
  const auto asked = list_options(options);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (asked[i].value == recorded[i].value || is_of_estimates(asked[i].key)) continue;
    throw BadInput(
        fmt::format("{} = {}: of an episode by touch a replay reads {}* and {}* only, "
                    "and does not change what was done and sensed",
                    asked[i].key, asked[i].value, kTracking, kResting));
  }
  return options.touch;
}

Replayed replay_episode(const ReplayArguments& arguments, const recording::Recording& recording) {
  if (recording.estimates.empty()) {
    throw BadInput(fmt::format(
        "{} is an episode with the true pose of the object: nothing was estimated in it (palpate "
        "rollout --touch --record 1 records one by touch)",
        arguments.recording));
  }
  const auto options = episode_options(recording, arguments.common, arguments.recording);
  return {relocate::replay_episode(recording, options), recording.frames.size(), ""};
}

Replayed replay_recording(const ReplayArguments& arguments) {
  const auto recording = recording::read_recording(arguments.recording);
  if (relocate::is_episode(recording)) return replay_episode(arguments, recording);
  const auto options = replay_options(recording, arguments.common, arguments.recording);
  const geometry::ObjectModel object(recording.header.object);
  auto log = recording::event_log(recording).until(estimation::TouchEvent::held);
  const auto hand = skills::calibrated_hand(recording.header.hand, log, options.pick.calibrate);
  const auto held = log.at(estimation::TouchEvent::held);
  Replayed replayed{
      estimation::PoseEstimator(object, options.pick_options().estimation, recording.header.seed)
          .held(hand, log, held),
      recording.frames.size(), held ? "" : end_of(recording)};
  replayed.weighed = weighed_by_pick(recording.header);
  if (!replayed.weighed.empty()) {
    replayed.about = fmt::format("of {} alone, which was simulated; the pick weighed {}\n",
                                 recording.header.object.name, replayed.weighed);
  }
  return replayed;
}

Replayed replay_bag(const ReplayArguments& arguments) {
  auto answer = estimate_from_bag(arguments.recording, arguments.bag, arguments.common);
  Replayed replayed{std::move(answer.estimate), answer.messages, ""};
  replayed.about = fmt::format("{} in the hand {}, {:.2f} s after the first of {} messages\n",
                               answer.object, answer.hand, answer.at, answer.messages);
  return replayed;
}

/// A recording names its object, hand and instant itself.
void refuse_bag_options(const std::vector<CLI::Option*>& of_bags, const std::string& recording) {
  for (const CLI::Option* const option : of_bags) {
    if (option->count() == 0) continue;
    throw BadInput(fmt::format("{} is an option of bags (MCAP), and {} is not one",
                               option->get_name(), recording));
  }
}

int replay(const ReplayArguments& arguments) {
  std::optional<Notice> notice(std::in_place, "estimating", arguments.common.quiet);
  const auto replayed =
      ros2::is_bag(arguments.recording) ? replay_bag(arguments) : replay_recording(arguments);
  const auto& posterior = replayed.estimate.posterior;
  notice.reset();
  if (!arguments.common.json) fmt::print("{}", replayed.about);
  if (arguments.common.json) {
    auto report = posterior_json(posterior);
    report.update({{"path", arguments.recording},
                   {"messages", replayed.messages},
                   {"pick_weighed",
                    replayed.weighed.empty() ? nlohmann::json() : nlohmann::json(replayed.weighed)},
                   {"hint", posterior.modes.empty() ? replayed.hint : ""}});
    print_json(report);
  } else if (posterior.modes.empty() && !replayed.hint.empty()) {
    fmt::print("{}: {}\n", colored_status(localization::to_string(posterior.status)),
               replayed.hint);
  } else {
    fmt::print("{}, {} contacts, {:.2f} s\n",
               colored_status(localization::to_string(posterior.status)),
               replayed.estimate.contacts.size(), posterior.seconds);
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
  accept_folder_of_pick(
      *command
           .add_option("recording", arguments->recording,
                       "recording.h5 of a pick, or its folder; or a bag: an MCAP file or the "
                       "folder of ros2 bag record")
           ->required());
  const auto of_bags = add_bag_options(command, arguments->bag);
  add_common_options(command, arguments->common, kConfig);
  command.footer(
      "Uses the recording's own configuration and seed, and so reproduces the pose of a pick of "
      "one\n"
      "known object bit for bit; --set changes the estimator's options (palpate options replay),\n"
      "and no others: what the robot did and sensed is recorded. Of a pick among candidates it\n"
      "estimates the pose of the simulated object alone, and says so.\n\n"
      "From an MCAP file of ROS 2 messages it uses the joint states, the contacts of each finger\n"
      "and the transforms from the world to the mount (docs/ros2.md). A file that `palpate export\n"
      "mcap` wrote names its hand and its object, unless that is of a mesh file; for others the\n"
      "pose is that of the last instant at which two fingers touch, or of --at.\n\n"
      "Examples:\n"
      "  palpate replay out/pick-mug-2\n"
      "  palpate replay out/pick-mug-2/recording.h5 --set estimation.free_space=false --json\n"
      "  palpate replay run.mcap --object part.stl --hand my_hand.xml --mount-frame wrist\n"
      "  palpate replay run.mcap --object mug --at 12.5 --json");
  command.callback([arguments, of_bags, &chosen] {
    chosen = [arguments, of_bags] {
      if (!ros2::is_bag(arguments->recording)) refuse_bag_options(of_bags, arguments->recording);
      return replay(*arguments);
    };
  });
}

}  // namespace palpate::app
