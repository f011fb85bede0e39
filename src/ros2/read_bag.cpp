// SPDX-License-Identifier: Apache-2.0
#include "palpate/ros2/read_bag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <string_view>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/ros2/cdr.hpp"
#include "palpate/ros2/export_recording.hpp"
#include "ros2/mcap_reader.hpp"
#include "ros2/mcap_records.hpp"

namespace palpate::ros2 {
namespace {

constexpr std::size_t kMaxNamedTopics = 12;  // in a message

/// "note lift: mark held" as it was; nothing for what says nothing like that.
std::optional<recording::Event> event_of(std::string_view text, double time) {
  const std::size_t space = text.find(' '), colon = text.find(": ");
  if (space == std::string_view::npos || colon == std::string_view::npos || colon < space) {
    return std::nullopt;
  }
  for (const auto kind :
       {recording::EventKind::begin, recording::EventKind::note, recording::EventKind::end}) {
    if (recording::to_string(kind) != text.substr(0, space)) continue;
    return recording::Event{time, kind, std::string(text.substr(space + 1, colon - space - 1)),
                            std::string(text.substr(colon + 2))};
  }
  return std::nullopt;
}

using EventTexts = std::vector<std::pair<std::uint64_t, std::string>>;  // texts by time, ns

/// What is no text is ignored.
void take_event(const McapMessage& message, EventTexts& events) {
  try {
    events.emplace_back(message.log_time, deserialize<String>(message.data).data);
  } catch (const BadInput&) {
  }
}

std::string why_none(const StreamCounts& counts, const RobotInterface& interface,
                     const hand::Description& hand) {
  if (!counts.last_error.empty()) return counts.last_error;
  if (counts.joint_states == 0) {
    return fmt::format("no joint of the hand {} in {}", hand.name, interface.joint_states);
  }
  return fmt::format("{} joint states, but no transform from {} to {}, or not all joints of {}",
                     counts.joint_states, interface.world, interface.mount, hand.name);
}

std::string list_of(const std::set<std::string, std::less<>>& topics) {
  std::string text;
  std::size_t count = 0;
  for (const auto& topic : topics) {
    text += (text.empty() ? "" : ", ") +
            (count < kMaxNamedTopics ? fmt::format("{:?}", topic) : std::string("..."));
    if (count++ == kMaxNamedTopics) break;
  }
  return text.empty() ? "none" : text;
}

bool begins_with(const std::filesystem::path& path, std::string_view head) {
  std::ifstream in(path, std::ios::binary);
  std::string begin(head.size(), '\0');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return in && begin == head;
}

/// Whether a file is a bag that is no MCAP: in SQLite, as those before Iron are, or of ROS 1.
bool is_other_bag(const std::filesystem::path& path) {
  return begins_with(path, "SQLite format 3") || begins_with(path, "#ROSBAG V");
}

std::string how_to_convert(const std::filesystem::path& path) {
  return fmt::format(
      "{0} is no MCAP; rosbags-convert --src {0} --dst DIR --dst-storage mcap makes one "
      "(pip install rosbags), and so does ros2 bag convert",
      path.string());
}

}  // namespace

std::map<std::string, std::string> bag_metadata(const std::filesystem::path& path) {
  auto metadata = read_mcap(bag_files(path).front(), [](const McapMessage&) {}).metadata;
  return metadata[kMetadata];
}

bool is_bag(const std::filesystem::path& path) {
  return std::filesystem::is_directory(path) || begins_with(path, kMcapMagic) || is_other_bag(path);
}

std::vector<std::filesystem::path> bag_files(const std::filesystem::path& path) {
  if (is_other_bag(path)) throw BadInput(how_to_convert(path));
  if (!std::filesystem::is_directory(path)) return {path};
  std::vector<std::filesystem::path> files;
  bool others = false;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    if (entry.path().extension() == ".mcap") files.push_back(entry.path());
    others = others || (entry.is_regular_file() && is_other_bag(entry.path()));
  }
  if (files.empty() && others) throw BadInput(how_to_convert(path));
  if (files.empty())
    throw BadInput(fmt::format("{} has neither a recording.h5 nor a file *.mcap", path.string()));
  std::ranges::sort(files, [](const auto& a, const auto& b) {  // bag_2 before bag_10
    const std::string one = a.filename().string(), other = b.filename().string();
    return one.size() != other.size() ? one.size() < other.size() : one < other;
  });
  return files;
}

Bag read_bag(const std::filesystem::path& path, const hand::Description& hand,
             const RobotInterface& interface, const StreamOptions& options) {
  Bag bag;
  ReadingStream stream(hand, interface, options);
  std::set<std::string, std::less<>> topics;
  EventTexts events;
  std::uint64_t restarts = 0;
  const auto take = [&](const McapMessage& message) {
    if (!topics.contains(message.topic)) topics.emplace(message.topic);
    if (message.encoding != "cdr") return;
    if (message.type == String::kType && message.topic == interface.palpate + "/events") {
      take_event(message, events);
    }
    auto reading = stream.take(message.topic, message.type, message.data, message.log_time);
    if (!reading) return;
    if (restarts != stream.counts().restarts) bag.readings.clear();
    restarts = stream.counts().restarts;
    bag.readings.push_back(std::move(*reading));
  };
  for (const auto& file : bag_files(path)) {
    const McapContents contents = read_mcap(file, take);
    bag.messages += contents.messages;
    bag.complete = bag.complete && contents.complete;
  }
  bag.counts = stream.counts();
  if (bag.readings.empty()) {
    throw BadInput(fmt::format("{}: no reading of a hand: {}; its topics: {}", path.string(),
                               why_none(bag.counts, interface, hand), list_of(topics)));
  }
  const auto start = static_cast<double>(*stream.start());
  for (const auto& [time, text] : events) {
    auto event = event_of(text, 1e-9 * (static_cast<double>(time) - start));
    if (event) bag.events.push_back(std::move(*event));
  }
  return bag;
}

}  // namespace palpate::ros2
