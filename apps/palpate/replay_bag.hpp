// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "common.hpp"
#include "palpate/estimation/estimate.hpp"
#include "palpate/ros2/robot_interface.hpp"

namespace palpate::app {

/// What an MCAP file does not say, or what is to be taken instead.
struct BagArguments {
  std::string object, hand;
  std::optional<double> at;  ///< s from the first reading
  ros2::RobotInterface interface;
};

/// Adds the options that only an MCAP file needs, and returns them.
std::vector<CLI::Option*> add_bag_options(CLI::App& command, BagArguments& arguments);

struct BagEstimate {
  std::string object, hand;
  double at = 0;  ///< s from the first reading
  std::uint64_t messages = 0;
  estimation::HeldPoseEstimate estimate;
};

/// The pose in the hand from messages of ROS 2: where the file has a pick's events as its
/// estimator had it, else from the contacts at one instant alone.
/// @throws BadInput for a file without the hand's readings, or in which nothing is ever touched
BagEstimate estimate_from_bag(const std::string& path, const BagArguments& arguments,
                              const CommonOptions& common);

}  // namespace palpate::app
