// SPDX-License-Identifier: Apache-2.0
#include "interface_option.hpp"

namespace palpate::app {

void add_interface_options(CLI::App& command, ros2::RobotInterface& interface) {
  command.add_option("--world-frame", interface.world, "ROS 2 frame in which poses are given")
      ->option_text("FRAME")
      ->capture_default_str();
  command.add_option("--mount-frame", interface.mount, "ROS 2 frame of the hand's mount")
      ->option_text("FRAME")
      ->capture_default_str();
  command.add_option("--joint-states", interface.joint_states, "topic of the joint states")
      ->option_text("TOPIC")
      ->capture_default_str();
  command
      .add_option("--contacts", interface.contacts,
                  "prefix of the contact topics; the finger's name follows")
      ->option_text("TOPIC")
      ->capture_default_str();
  command
      .add_option("--fingertip-wrenches", interface.fingertip_wrenches,
                  "prefix of topics with the wrench on a fingertip, used instead of its contacts")
      ->option_text("TOPIC")
      ->capture_default_str();
  command
      .add_option_function<std::string>(
          "--taxel-layout",
          [&interface](const std::string& path) {
            interface.taxel_layout = tactile::read_taxel_layout(path);
          },
          "CSV of the taxels, if their raw values are sent instead of contacts")
      ->option_text("FILE");
  command
      .add_option("--taxels", interface.taxels,
                  "prefix of topics with the raw values of a finger's taxels")
      ->option_text("TOPIC")
      ->capture_default_str();
}

void add_best_effort_option(CLI::App& command, ros2::RobotInterface& interface) {
  command.add_flag("--best-effort", interface.best_effort,
                   "also accept best effort senders of sensor data; messages may be lost");
}

}  // namespace palpate::app
