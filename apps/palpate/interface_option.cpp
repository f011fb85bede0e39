// SPDX-License-Identifier: Apache-2.0
#include "interface_option.hpp"

namespace palpate::app {

std::vector<CLI::Option*> add_interface_options(CLI::App& command,
                                                ros2::RobotInterface& interface) {
  std::vector<CLI::Option*> added;
  const auto add = [&](const char* name, std::string& value, const char* kind, const char* what) {
    added.push_back(
        command.add_option(name, value, what)->option_text(kind)->capture_default_str());
  };
  add("--world-frame", interface.world, "FRAME", "ROS 2 frame in which poses are given");
  add("--mount-frame", interface.mount, "FRAME", "ROS 2 frame of the hand's mount");
  add("--joint-states", interface.joint_states, "TOPIC", "topic of the joint states");
  add("--actuator-states", interface.actuator_states, "TOPIC", "topic of the actuators' efforts");
  add("--wrench", interface.wrench, "TOPIC", "topic of the force on the mount");
  added.push_back(command
                      .add_option_function<std::string>(
                          "--tf",
                          [&interface](const std::string& topic) {
                            interface.tf = topic;
                            interface.tf_static = topic + "_static";
                          },
                          "topic of the transforms; the static ones' is its name and _static")
                      ->option_text("TOPIC")
                      ->default_str(interface.tf));
  add("--contacts", interface.contacts, "TOPIC",
      "prefix of the contact topics; the finger's name follows");
  add("--fingertip-wrenches", interface.fingertip_wrenches, "TOPIC",
      "prefix of topics with the wrench on a fingertip, used instead of its contacts");
  added.push_back(command
                      .add_option_function<std::string>(
                          "--taxel-layout",
                          [&interface](const std::string& path) {
                            interface.taxel_layout = tactile::read_taxel_layout(path);
                          },
                          "CSV of the taxels, if their raw values are sent instead of contacts")
                      ->option_text("FILE"));
  add("--taxels", interface.taxels, "TOPIC",
      "prefix of topics with the raw values of a finger's taxels");
  return added;
}

CLI::Option* add_best_effort_option(CLI::App& command, ros2::RobotInterface& interface) {
  return command.add_flag("--best-effort", interface.best_effort,
                          "also accept best effort senders of sensor data; messages may be lost");
}

}  // namespace palpate::app
