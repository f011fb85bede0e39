// SPDX-License-Identifier: Apache-2.0
#include "bridge/hand_commands.hpp"

#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/hand/nearest_mount.hpp"
#include "palpate/ros2/cdr.hpp"
#include "palpate/ros2/robot_messages.hpp"

namespace palpate::bridge {
namespace {

std::uint64_t stamp_of(const ros2::Header& header, std::uint64_t latest) {
  const std::uint64_t stamp = ros2::nanoseconds_of(header.stamp);
  if (stamp > latest) throw BadInput(fmt::format("a stamp of the future, {} ns", stamp));
  return stamp;
}

}  // namespace

template <class Take>
HandCommands::Effect HandCommands::guarded(Take&& take) {
  try {
    return take();
  } catch (const BadInput&) {
    ++malformed_;
    return Effect::none;
  }
}

/// Joints and mount of one stamp are one command. Who never commands the mount is not waited for.
HandCommands::Effect HandCommands::complete() {
  if (!joints_at_ || (mount_at_ && *mount_at_ != *joints_at_)) return Effect::none;
  if (*joints_at_ <= done_) return Effect::repeat;
  done_ = *joints_at_;
  return Effect::step;
}

/// Positions have no stamp: they and the mount's next target are one command.
HandCommands::Effect HandCommands::complete_positions() {
  if (!new_positions_ || (mount_at_ && !new_mount_)) return Effect::none;
  new_positions_ = new_mount_ = false;
  return Effect::step;
}

HandCommands::Effect HandCommands::take_joints(std::string_view cdr, std::uint64_t latest) {
  return guarded([&] {
    const auto trajectory = ros2::deserialize<ros2::JointTrajectory>(cdr);
    if (trajectory.points.empty()) throw BadInput("a trajectory without points");
    const auto& positions = trajectory.points.back().positions;
    if (positions.size() != trajectory.joint_names.size()) {
      throw BadInput(fmt::format("{} positions for {} joints", positions.size(),
                                 trajectory.joint_names.size()));
    }
    hand::ActuatorVector target = command_.positions;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      target[hand_.actuator(trajectory.joint_names[i])] =
          plausible(positions[i], -kMaxAngle, kMaxAngle, "a position");
    }
    const std::uint64_t stamp = stamp_of(trajectory.header, latest);
    if (stamp == 0) {
      command_.positions = target;
      return Effect::step;
    }
    if (joints_at_ && stamp < *joints_at_) return Effect::none;  // late
    joints_at_ = stamp;
    if (stamp > done_) command_.positions = target;
    return complete();
  });
}

HandCommands::Effect HandCommands::take_mount(std::string_view cdr, std::uint64_t latest) {
  return guarded([&] {
    const auto target = ros2::deserialize<ros2::PoseStamped>(cdr);
    const std::string& frame = target.header.frame_id;
    if (!frame.empty() && frame != world_) {
      throw BadInput(fmt::format("a target in the frame {:?}, not {:?}", frame, world_));
    }
    const Eigen::Isometry3d T_world_mount = ros2::transform_of(target.pose);
    const std::uint64_t stamp = stamp_of(target.header, latest);
    if (stamp == 0) {
      command_.mount = hand::nearest_mount(T_world_mount, command_.mount);
      new_positions_ = new_mount_ = false;
      return Effect::step;
    }
    if (mount_at_ && stamp < *mount_at_) return Effect::none;
    mount_at_ = stamp;
    new_mount_ = true;
    if (stamp > done_) command_.mount = hand::nearest_mount(T_world_mount, command_.mount);
    if (new_positions_) return complete_positions();
    return stamp > done_ ? complete() : Effect::none;
  });
}

HandCommands::Effect HandCommands::take_positions(std::string_view cdr) {
  return guarded([&] {
    const auto message = ros2::deserialize<ros2::Float64MultiArray>(cdr);
    if (message.data.size() != static_cast<std::size_t>(hand_.actuator_count())) {
      throw BadInput(fmt::format("{} positions for {} actuators", message.data.size(),
                                 hand_.actuator_count()));
    }
    hand::ActuatorVector target = command_.positions;
    for (Eigen::Index i = 0; i < target.size(); ++i) {
      target[i] =
          plausible(message.data[static_cast<std::size_t>(i)], -kMaxAngle, kMaxAngle, "a position");
    }
    command_.positions = target;
    new_positions_ = true;
    return complete_positions();
  });
}

}  // namespace palpate::bridge
