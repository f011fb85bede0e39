// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "palpate/bridge/hand_peer.hpp"
#include "palpate/ros2/messages/geometry_msgs.hpp"
#include "palpate/ros2/messages/trajectory_msgs.hpp"

namespace palpate::bridge {

/// The command that arriving messages make up.
class HandCommands {
 public:
  enum class Effect {
    none,    ///< nothing new yet
    step,    ///< a new command is there, whole
    repeat,  ///< one that has been there before
  };

  /// @param world  frame of the mount's targets
  HandCommands(const hand::Description& hand, hand::HandCommand start, std::string world = "world")
      : hand_(hand), command_(std::move(start)), world_(std::move(world)) {}

  /// Each counts what cannot be used as malformed, and changes nothing then. A stamp of zero is the
  /// time of arrival: the message is a command of its own.
  /// @param latest  ns, stamps after which are not believed: all that comes later would be late
  Effect take_joints(std::string_view cdr, std::uint64_t latest = UINT64_MAX);
  Effect take_mount(std::string_view cdr, std::uint64_t latest = UINT64_MAX);
  Effect take_positions(std::string_view cdr);

  const hand::HandCommand& command() const { return command_; }
  std::uint64_t malformed() const { return malformed_; }

 private:
  template <class Take>
  Effect guarded(Take&& take);
  Effect complete();
  Effect complete_positions();

  const hand::Description& hand_;
  hand::HandCommand command_;
  std::string world_;
  std::optional<std::uint64_t> joints_at_, mount_at_;  ///< stamps of the latest, ns
  std::uint64_t done_ = 0;                             ///< stamp of the latest whole command
  std::uint64_t malformed_ = 0;
  bool new_positions_ = false, new_mount_ = false;  ///< since the latest whole command
};

}  // namespace palpate::bridge
