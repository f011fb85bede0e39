// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

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

  HandCommands(const hand::Description& hand, hand::HandCommand start)
      : hand_(hand), command_(std::move(start)) {}

  /// Each counts what cannot be used as malformed, and changes nothing then.
  Effect take_joints(std::string_view cdr);
  Effect take_mount(std::string_view cdr);
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
  std::optional<std::uint64_t> joints_at_, mount_at_;  ///< stamps of the latest, ns
  std::uint64_t done_ = 0;                             ///< stamp of the latest whole command
  std::uint64_t malformed_ = 0;
  bool new_positions_ = false, new_mount_ = false;  ///< since the latest whole command
};

}  // namespace palpate::bridge
