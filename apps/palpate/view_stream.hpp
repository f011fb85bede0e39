// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "common.hpp"
#include "live_view.hpp"
#include "palpate/ros2/robot_interface.hpp"

namespace palpate::app {

/// What is watched of ROS 2.
struct StreamArguments {
  CommonOptions common;
  std::string object = "mug", hand;
  std::optional<int> domain;
  ros2::RobotInterface interface;
};

/// Shows a stream until interrupted, and reports what came.
/// @throws BadInput in a build without Cyclone DDS
int view_stream(const StreamArguments& arguments, LiveView& live);

}  // namespace palpate::app
