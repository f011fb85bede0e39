// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
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
/// @param open  begins to serve; called once all that is asked for is there
/// @throws BadInput in a build without Cyclone DDS
int view_stream(const StreamArguments& arguments, const std::function<LiveView&()>& open);

}  // namespace palpate::app
