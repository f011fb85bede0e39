// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "palpate/ros2/messages/std_msgs.hpp"

namespace palpate::ros2 {

struct KeyValue {
  static constexpr std::string_view kType = "diagnostic_msgs/msg/KeyValue";
  std::string key, value;
  static void fields(auto& m, auto&& v) {
    v("key", m.key);
    v("value", m.value);
  }
};

struct DiagnosticStatus {
  static constexpr std::string_view kType = "diagnostic_msgs/msg/DiagnosticStatus";
  static constexpr std::byte kOk{0}, kWarn{1}, kError{2}, kStale{3};
  std::byte level{0};
  std::string name, message, hardware_id;
  std::vector<KeyValue> values;
  static void fields(auto& m, auto&& v) {
    v("level", m.level);
    v("name", m.name);
    v("message", m.message);
    v("hardware_id", m.hardware_id);
    v("values", m.values);
  }
};

struct DiagnosticArray {
  static constexpr std::string_view kType = "diagnostic_msgs/msg/DiagnosticArray";
  Header header;
  std::vector<DiagnosticStatus> status;
  static void fields(auto& m, auto&& v) {
    v("header", m.header);
    v("status", m.status);
  }
};

}  // namespace palpate::ros2
