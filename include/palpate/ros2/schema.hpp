// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>

#include "palpate/ros2/cdr.hpp"

namespace palpate::ros2 {

/// The type's name on DDS: "sensor_msgs/msg/JointState" is "sensor_msgs::msg::dds_::JointState_".
std::string dds_type_name(std::string_view type);

/// The topic's name on DDS: "/joint_states" is "rt/joint_states".
std::string dds_topic_name(std::string_view topic);

/// Writes definitions in ROS 2's msg format, each type once, in the order in which they are met.
class SchemaWriter {
 public:
  template <Message M>
  void add() {
    const std::string name = short_name(M::kType);
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) return;
    known_.push_back(name);
    if (known_.size() > 1) text_ += std::string(80, '=') + "\nMSG: " + name + "\n";
    const M empty;
    M::fields(empty, [this](std::string_view field, const auto& value) {
      text_ += fmt::format("{} {}\n", name_of<std::remove_cvref_t<decltype(value)>>(), field);
    });
    M::fields(empty, [this](std::string_view, const auto& value) {
      this->add_part<std::remove_cvref_t<decltype(value)>>();
    });
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  /// "std_msgs/msg/Header" as fields name it, "std_msgs/Header".
  static std::string short_name(std::string_view type) {
    return fmt::format("{}{}", type.substr(0, type.find('/')), type.substr(type.rfind('/')));
  }

  template <class T>
  void add_part() {
    if constexpr (Message<T>) {
      add<T>();
    } else if constexpr (requires { typename T::value_type; }) {
      add_part<typename T::value_type>();
    }
  }

  template <class T>
  static std::string name_of() {
    if constexpr (Message<T>) {
      return short_name(T::kType);
    } else if constexpr (std::same_as<T, std::string>) {
      return "string";
    } else if constexpr (std::same_as<T, bool>) {
      return "bool";
    } else if constexpr (std::same_as<T, std::byte>) {
      return "byte";
    } else if constexpr (std::floating_point<T>) {
      return fmt::format("float{}", 8 * sizeof(T));
    } else if constexpr (std::integral<T>) {
      return fmt::format("{}int{}", std::unsigned_integral<T> ? "u" : "", 8 * sizeof(T));
    } else if constexpr (requires { std::tuple_size<T>::value; }) {
      return fmt::format("{}[{}]", name_of<typename T::value_type>(), std::tuple_size_v<T>);
    } else {
      return name_of<typename T::value_type>() + "[]";
    }
  }

  std::string text_;
  std::vector<std::string> known_;
};

/// The message's definition with those of all that it is made of, in ROS 2's msg format, as MCAP
/// and rosbag2 store it ("ros2msg").
template <Message M>
std::string message_schema() {
  SchemaWriter writer;
  writer.add<M>();
  return writer.text();
}

}  // namespace palpate::ros2
