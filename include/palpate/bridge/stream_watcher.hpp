// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "palpate/bridge/participant.hpp"
#include "palpate/recording/sink.hpp"
#include "palpate/ros2/reading_stream.hpp"

namespace palpate::bridge {

/// What a watcher has seen.
struct WatchReport {
  ros2::StreamCounts received;
  std::uint64_t messages = 0, lost = 0, estimates = 0;
  std::string refused;      ///< topics of which a sender's QoS offers too little
  double pose_latency = 0;  ///< s from the stamp of a reading to its pose here, of the last one
};

/// Listens to a robot, and to who estimates beside it, and passes it on as a recording that comes
/// about. It publishes nothing.
class StreamWatcher {
 public:
  using Observer = std::function<void(const WatchReport&)>;

  /// Keeps references to participant, hand and sink.
  /// @param observer  called once a second
  StreamWatcher(Participant& participant, const hand::Description& hand,
                const ros2::RobotInterface& interface, recording::Sink& sink,
                Observer observer = {});
  ~StreamWatcher();

  /// Watches until a stop is requested.
  void run(const std::stop_token& stop);

  WatchReport report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::bridge
