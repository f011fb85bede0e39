// SPDX-License-Identifier: Apache-2.0
#include "bridge/stream_readers.hpp"

#include "palpate/ros2/messages/geometry_msgs.hpp"
#include "palpate/ros2/messages/sensor_msgs.hpp"
#include "palpate/ros2/messages/std_msgs.hpp"

namespace palpate::bridge {

Qos sensor_qos() { return {.reliable = true, .latched = false, .depth = 1000}; }

void add_stream_readers(Participant& participant, const hand::Description& hand,
                        const ros2::RobotInterface& interface, std::deque<RawReader>& readers) {
  const auto add = [&](const std::string& topic, std::string_view type, const Qos& qos) {
    readers.emplace_back(participant, topic, type, qos);
  };
  const Qos latched{.reliable = true, .latched = true, .depth = 100};
  add(interface.tf_static, ros2::TFMessage::kType, latched);
  add(interface.tf, ros2::TFMessage::kType, sensor_qos());
  for (const auto& finger : hand.fingers) {
    add(interface.contacts_of(finger), ros2::PointCloud2::kType, sensor_qos());
    add(interface.fingertip_wrench_of(finger), ros2::WrenchStamped::kType, sensor_qos());
    if (!interface.taxel_layout.contains(finger.name)) continue;
    add(interface.taxels_of(finger), ros2::Float64MultiArray::kType, sensor_qos());
    add(interface.taxels_of(finger), ros2::Float32MultiArray::kType, sensor_qos());
  }
  add(interface.wrench, ros2::WrenchStamped::kType, sensor_qos());
  add(interface.actuator_states, ros2::JointState::kType, sensor_qos());
  add(interface.joint_states, ros2::JointState::kType, sensor_qos());
}

}  // namespace palpate::bridge
