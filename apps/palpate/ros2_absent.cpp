// SPDX-License-Identifier: Apache-2.0
// In the place of ros2.cpp and view_stream.cpp where there is no Cyclone DDS.
#include "common.hpp"
#include "palpate/core/error.hpp"
#include "view_stream.hpp"

namespace palpate::app {
namespace {

[[noreturn]] int refuse() {
  throw BadInput("built without Cyclone DDS: install cyclonedds-dev and build again");
}

}  // namespace

std::vector<OptionInfo> ros2_estimate_option_list() { refuse(); }

void add_ros2(CLI::App& program, Command& chosen) {
  auto& command = *program.add_subcommand(
      "ros2", "Exchange messages with ROS 2 nodes: not in this build, which found no Cyclone DDS");
  command.allow_extras();
  command.callback([&chosen] { chosen = &refuse; });
}

int view_stream(const StreamArguments&, const std::function<LiveView&()>&) { refuse(); }

}  // namespace palpate::app
