// SPDX-License-Identifier: Apache-2.0
#include "replay_bag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>

#include "hand_option.hpp"
#include "interface_option.hpp"
#include "palpate/core/error.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/recording/touch_log.hpp"
#include "palpate/ros2/read_bag.hpp"
#include "palpate/skills/explore/calibrate_phase.hpp"
#include "replay_options.hpp"

namespace palpate::app {
namespace {

constexpr int kFingers = 2;  // that touch at the instant that is chosen, unless one is named

using Metadata = std::map<std::string, std::string>;

std::string value_of(const Metadata& metadata, const std::string& key) {
  const auto found = metadata.find(key);
  return found == metadata.end() ? "" : found->second;
}

/// That of the export; `otherwise` for a file that states none.
std::uint64_t seed_of(const Metadata& metadata, const std::string& path, std::uint64_t otherwise) {
  const std::string text = value_of(metadata, "seed");
  if (text.empty()) return otherwise;
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error == std::errc() && end == text.data() + text.size()) return seed;
  throw BadInput(fmt::format("{}: the seed {:.40?} of its metadata is no number", path, text));
}

/// Those that the file was made with, changed by --config and --set.
evaluation::TrialOptions options_of(const Metadata& metadata, const std::string& path,
                                    const CommonOptions& common) {
  evaluation::TrialOptions options;
  parse_toml(value_of(metadata, "config_toml"), path, options, Earlier::accepted);
  const evaluation::TrialOptions recorded = options;
  if (!common.config.empty()) load_toml(common.config, options);
  for (const auto& assignment : common.set) apply_setting(assignment, options);
  refuse_what_is_recorded(recorded, options, path);
  return options;
}

estimation::EventLog log_of(const ros2::Bag& bag) {
  recording::Recording recording;
  for (const auto& reading : bag.readings) recording.frames.push_back({reading, {}, {}});
  recording.events = bag.events;
  return recording::event_log(recording);
}

/// The reading at a time, or the last one in which enough fingers touch.
std::size_t instant_of(const estimation::EventLog& log, std::optional<double> at,
                       const std::string& path) {
  const auto& readings = log.readings;
  const auto found =
      std::find_if(readings.rbegin(), readings.rend(), [&](const hand::HandReading& reading) {
        return at ? reading.time <= *at : hand::touching_fingers(reading) >= kFingers;
      });
  if (found != readings.rend()) return static_cast<std::size_t>(readings.rend() - found) - 1;
  if (at) throw BadInput(fmt::format("--at {}: {} has no reading before", *at, path));
  throw BadInput(fmt::format("{}: in none of {} readings do {} fingers touch anything", path,
                             readings.size(), kFingers));
}

void warn_of(const ros2::Bag& bag, const std::string& path, bool quiet) {
  const ros2::StreamCounts& counts = bag.counts;
  if (quiet) return;
  if (!bag.complete) fmt::print(stderr, "{} has no end: what there is of it is used\n", path);
  if (counts.restarts > 0) {
    fmt::print(stderr, "the clock was set back {} times: what comes after the last is used\n",
               counts.restarts);
  }
  if (counts.malformed + counts.out_of_order + counts.gaps + counts.incomplete == 0) return;
  fmt::print(stderr, "{} malformed and {} late messages dropped, {} gaps, {} joint states unused\n",
             counts.malformed, counts.out_of_order, counts.gaps, counts.incomplete);
  if (!counts.last_error.empty()) fmt::print(stderr, "  {}\n", counts.last_error);
}

}  // namespace

std::vector<CLI::Option*> add_bag_options(CLI::App& command, BagArguments& arguments) {
  std::vector<CLI::Option*> added = {
      command
          .add_option("--object", arguments.object,
                      "for an MCAP file: the object that the hand touches, built in or a mesh file "
                      "in metres (default: the object of the export)")
          ->option_text("OBJECT"),
      &add_hand_option(command, arguments.hand),
      command
          .add_option("--at", arguments.at,
                      "for an MCAP file: instant of the estimate, s after the first reading")
          ->option_text("S")};
  const auto interface = add_interface_options(command, arguments.interface);
  added.insert(added.end(), interface.begin(), interface.end());
  return added;
}

BagEstimate estimate_from_bag(const std::string& path, const BagArguments& arguments,
                              const CommonOptions& common) {
  const Metadata metadata = ros2::bag_metadata(path);
  const auto options = options_of(metadata, path, common);
  const std::uint64_t seed = seed_of(metadata, path, common.seed);
  BagEstimate answer;
  answer.object = arguments.object.empty() ? value_of(metadata, "object") : arguments.object;
  answer.hand = arguments.hand.empty() ? value_of(metadata, "hand") : arguments.hand;
  if (answer.object.empty()) {
    throw BadInput(fmt::format("{} does not say what was touched: --object does", path));
  }
  const auto described = load_hand_with_progress(answer.hand, common.quiet).hand;
  answer.hand = described.name;
  const ros2::Bag bag = ros2::read_bag(path, described, arguments.interface);
  warn_of(bag, path, common.quiet);
  answer.messages = bag.messages;
  const geometry::ObjectModel object(geometry::load_known_object(answer.object));
  const auto log = log_of(bag);
  auto until = arguments.at ? log : log.until(estimation::TouchEvent::held);
  const auto held = arguments.at ? std::nullopt : until.at(estimation::TouchEvent::held);
  const std::size_t at = held ? *held : instant_of(until, arguments.at, path);
  const auto hand = skills::calibrated_hand(described, until, options.pick.calibrate);
  estimation::PoseEstimator estimator(object, options.pick_options().estimation, seed);
  answer.at = until.readings[at].time;
  answer.estimate = estimator.held(hand, until, at);
  return answer;
}

}  // namespace palpate::app
