// SPDX-License-Identifier: Apache-2.0
#include "palpate/bridge/stream_watcher.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "bridge/stream_readers.hpp"
#include "bridge/wall_clock.hpp"
#include "palpate/ros2/cdr.hpp"

namespace palpate::bridge {
namespace {

constexpr double kPatience = 0.02;                      // s that one round waits
constexpr std::uint64_t kReportPeriod = 1'000'000'000;  // ns
constexpr std::size_t kMaxModes = 100;

double seconds(std::uint64_t from, std::uint64_t to) {
  return 1e-9 * (static_cast<double>(to) - static_cast<double>(from));
}

}  // namespace

struct StreamWatcher::Impl {
  Participant& participant;
  const hand::Description& hand;
  recording::Sink& sink;
  Observer observer;
  ros2::ReadingStream stream;
  std::deque<RawReader> readers;
  RawReader poses, modes, weights, status;
  WatchReport report;
  recording::EstimateRecord coming;  // whose weights have not come yet
  double shown_at = 0;         // s, of the last frame; goes on where the stream's clock is set back
  double offset = 0;           // s, from the stream's time to that which is shown
  std::uint64_t restarts = 0;  // of the stream, that the offset makes up for
  std::uint64_t reported_at = 0;

  Impl(Participant& at, const hand::Description& described, const ros2::RobotInterface& interface,
       recording::Sink& to, Observer given)
      : participant(at),
        hand(described),
        sink(to),
        observer(std::move(given)),
        stream(described, interface),
        poses(at, interface.palpate + "/estimate", ros2::PoseWithCovarianceStamped::kType, {}),
        modes(at, interface.palpate + "/modes", ros2::PoseArray::kType, {}),
        weights(at, interface.palpate + "/mode_weights", ros2::Float64MultiArray::kType, {}),
        status(at, interface.palpate + "/status", ros2::String::kType, {}) {
    add_stream_readers(participant, hand, interface, readers);
  }

  void receive() {
    for (RawReader& reader : readers) {
      reader.take([&](std::string_view cdr, std::uint64_t now) {
        ++report.messages;
        if (const auto reading = stream.take(reader.topic(), reader.type(), cdr, now)) {
          show(*reading);
        }
      });
    }
    take<ros2::PoseWithCovarianceStamped>(poses, [&](const auto& pose, std::uint64_t now) {
      report.pose_latency = seconds(ros2::nanoseconds_of(pose.header.stamp), now);
    });
    take<ros2::PoseArray>(modes, [&](const auto& message, std::uint64_t) { take_modes(message); });
    take<ros2::Float64MultiArray>(
        weights, [&](const auto& message, std::uint64_t) { take_weights(message.data); });
    take<ros2::String>(status, [&](const auto& message, std::uint64_t) {
      if (coming.modes.empty()) return;
      coming.status = message.data;
      add_estimate();
    });
  }

  void show(hand::HandReading reading) {
    if (restarts != stream.counts().restarts) offset = shown_at + hand::kTick - reading.time;
    restarts = stream.counts().restarts;
    reading.time += offset;
    shown_at = reading.time;
    sink.frame({reading, {}, std::nullopt});
  }

  /// Hands on what can be read; what cannot is another's fault, and dropped.
  template <class M, class Take>
  void take(RawReader& reader, Take&& taken) {
    reader.take([&](std::string_view cdr, std::uint64_t now) {
      ++report.messages;
      try {
        taken(ros2::deserialize<M>(cdr), now);
      } catch (const BadInput&) {
      }
    });
  }

  void take_modes(const ros2::PoseArray& message) {
    if (!stream.start() || message.poses.size() > kMaxModes) return;
    coming = {};
    coming.time = offset + seconds(*stream.start(), ros2::nanoseconds_of(message.header.stamp));
    for (const auto& pose : message.poses) {
      coming.modes.emplace_back().T_world_object = ros2::transform_of(pose);
    }
  }

  void take_weights(const std::vector<double>& values) {
    if (values.size() != coming.modes.size()) return;  // of another estimate
    for (std::size_t i = 0; i < coming.modes.size(); ++i) {
      coming.modes[i].weight = std::isfinite(values[i]) ? std::clamp(values[i], 0.0, 1.0) : 0;
    }
  }

  /// As a belief, of which there may be ten a second.
  void add_estimate() {
    recording::BeliefRecord belief{
        .time = coming.time, .source = "online", .in_hand = true, .poses = {}};
    for (const auto& mode : coming.modes) {
      belief.poses.push_back({mode.weight, mode.T_world_object});
    }
    sink.belief(belief);
    coming = {};
    ++report.estimates;
  }

  void notify() {
    const std::uint64_t now = wall_clock();
    if (!observer || now < reported_at + kReportPeriod) return;
    reported_at = now;
    update();
    observer(report);
  }

  void update() {
    report.received = stream.counts();
    report.lost = 0;
    report.refused = refused_topics(readers);
    for (const RawReader& reader : readers) report.lost += reader.lost();
  }
};

StreamWatcher::StreamWatcher(Participant& participant, const hand::Description& hand,
                             const ros2::RobotInterface& interface, recording::Sink& sink,
                             Observer observer)
    : impl_(new Impl(participant, hand, interface, sink, std::move(observer))) {}

StreamWatcher::~StreamWatcher() = default;

void StreamWatcher::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    impl_->participant.wait(kPatience);
    impl_->receive();
    impl_->notify();
  }
}

WatchReport StreamWatcher::report() const {
  impl_->update();
  return impl_->report;
}

}  // namespace palpate::bridge
