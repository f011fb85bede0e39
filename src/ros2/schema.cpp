// SPDX-License-Identifier: Apache-2.0
#include "palpate/ros2/schema.hpp"

namespace palpate::ros2 {

std::string dds_type_name(std::string_view type) {
  const std::size_t package = type.find('/'), name = type.rfind('/');
  return fmt::format("{}::msg::dds_::{}_", type.substr(0, package), type.substr(name + 1));
}

std::string dds_topic_name(std::string_view topic) { return fmt::format("rt{}", topic); }

}  // namespace palpate::ros2
