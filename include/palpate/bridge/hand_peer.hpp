// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "palpate/bridge/participant.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/ros2/reading_stream.hpp"

namespace palpate::bridge {

/// Topics of commands. docs/ros2.md says what they hold.
struct CommandTopics {
  std::string joints = "/palpate/hand_controller/joint_trajectory";  ///< JointTrajectory
  std::string positions = "/palpate/hand_controller/commands";       ///< Float64MultiArray
  std::string mount = "/palpate/mount_controller/target";            ///< PoseStamped
};

struct RemoteHandOptions {
  double timeout = 0.25;   ///< s that a step waits for a reading newer than the last
  double patience = 0.01;  ///< s that it waits for the other parts of a reading with its joints
  double connect = 10;     ///< s that sense(), and the first step, wait for the hand
  bool positions = false;  ///< commands joints by the topic `positions`, else `joints`
};

/// A hand behind ROS 2: commands are published, readings are made of what it publishes.
///
/// step() answers a reading newer than the last or, after `timeout`, the last one again with its
/// old time, which the executor's gate counts as late. Until a reading comes the steps after that
/// wait for a tick each, so that a hand that falls silent is stopped within the gate's limit of
/// ticks. The command is repeated then: one that was lost is made good, one that arrived is known
/// by its stamp, the wall clock's. Positions have none, and are not repeated once a reading has
/// come.
///
/// Nothing is commanded before somebody sends joint states, nor as long as messages come of which
/// no reading can be made. A hand that then reports nothing for 0.25 s is taken for one that
/// reports only when it is commanded, and cannot sense() before.
class RemoteHand : public hand::Hand {
 public:
  /// Keeps references to participant and description.
  RemoteHand(Participant& participant, const hand::Description& hand,
             const ros2::RobotInterface& interface = {}, const CommandTopics& topics = {},
             const RemoteHandOptions& options = {});
  ~RemoteHand() override;

  /// @throws BadInput if no reading has ever come within RemoteHandOptions::connect
  hand::HandReading step(const hand::HandCommand& command) override;
  /// @throws as step()
  std::optional<hand::HandReading> sense() override;

  const ros2::StreamCounts& counts() const;
  std::uint64_t messages() const;  ///< sent and received
  std::uint64_t repeats() const;   ///< commands that were sent again

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct HandServerOptions {
  bool real_time = false;  ///< a tick passes every 10 ms, else with every command
};

/// Makes a hand known to ROS 2: publishes its readings and steps it by the commands that come.
///
/// Without `real_time` the hand waits for commands: it makes one tick for each new stamp, and sends
/// the last reading again for a stamp that it knows.
class HandServer {
 public:
  /// Keeps references to all of them.
  HandServer(Participant& participant, hand::Hand& hand, const hand::Description& description,
             const ros2::RobotInterface& interface = {}, const CommandTopics& topics = {},
             const HandServerOptions& options = {});
  ~HandServer();

  /// Serves until a stop is requested. @param start  where the hand is commanded at first
  void run(const hand::HandCommand& start, const std::stop_token& stop);

  std::uint64_t ticks() const;
  std::uint64_t messages() const;  ///< sent and received
  std::uint64_t malformed() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::bridge
