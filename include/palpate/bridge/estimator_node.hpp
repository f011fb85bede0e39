// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "palpate/bridge/participant.hpp"
#include "palpate/estimation/held_pose_follower.hpp"
#include "palpate/ros2/reading_stream.hpp"

namespace palpate::bridge {

/// What became of a node's work.
struct NodeReport {
  ros2::StreamCounts received;
  std::uint64_t messages = 0;  ///< received and sent
  std::uint64_t lost = 0;      ///< that DDS says never came
  std::uint64_t poses = 0, estimates = 0, commands = 0;
  std::uint64_t failed = 0;  ///< estimates that could not be made of the readings
  std::string last_failure;  ///< why not, of the latest
  std::string refused;       ///< topics of which a sender's QoS offers too little
};

/// The estimator beside somebody's robot: reads what the hand publishes, and publishes the object's
/// pose.
///
/// Every reading is answered with the pose, carried along with the palm since the last estimate
/// (/palpate/estimate, /tf). Estimates are made by another thread, as often as they are done; each
/// is published with its modes, weights and markers. /palpate/command takes "start", "stop" (the
/// stream is then ignored) and "estimate" (discard all data and start again). Diagnostics come once
/// a second.
class EstimatorNode {
 public:
  /// Keeps references to participant, object and hand. @throws BadInput for a hand without links
  EstimatorNode(Participant& participant, const geometry::ObjectModel& object,
                const hand::Description& hand, const ros2::RobotInterface& interface = {},
                const estimation::HeldPoseOptions& options = {}, std::uint64_t seed = 0);
  ~EstimatorNode();

  using Observer = std::function<void(const NodeReport&)>;

  /// Works until a stop is requested.
  /// @param observer  called once a second
  void run(const std::stop_token& stop, const Observer& observer = {});

  NodeReport report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::bridge
