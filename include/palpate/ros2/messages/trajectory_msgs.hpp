// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/ros2/messages/std_msgs.hpp"

namespace palpate::ros2 {

struct JointTrajectoryPoint {
  static constexpr std::string_view kType = "trajectory_msgs/msg/JointTrajectoryPoint";
  std::vector<double> positions, velocities, accelerations, effort;
  Duration time_from_start;
  static void fields(auto& m, auto&& v) {
    v("positions", m.positions);
    v("velocities", m.velocities);
    v("accelerations", m.accelerations);
    v("effort", m.effort);
    v("time_from_start", m.time_from_start);
  }
};

struct JointTrajectory {
  static constexpr std::string_view kType = "trajectory_msgs/msg/JointTrajectory";
  Header header;
  std::vector<std::string> joint_names;
  std::vector<JointTrajectoryPoint> points;
  static void fields(auto& m, auto&& v) {
    v("header", m.header);
    v("joint_names", m.joint_names);
    v("points", m.points);
  }
};

}  // namespace palpate::ros2
