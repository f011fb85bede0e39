// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <vector>

#include "palpate/ros2/robot_interface.hpp"

namespace palpate::app {

/// Adds options for the frames and topics by which a hand is known to ROS 2.
/// @return these options, of the command
std::vector<CLI::Option*> add_interface_options(CLI::App& command, ros2::RobotInterface& interface);

/// Adds an option for sensors whose senders are best effort.
CLI::Option* add_best_effort_option(CLI::App& command, ros2::RobotInterface& interface);

}  // namespace palpate::app
