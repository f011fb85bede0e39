// SPDX-License-Identifier: Apache-2.0
#include "bridge/stream_readers.hpp"

#include "palpate/ros2/messages/geometry_msgs.hpp"
#include "palpate/ros2/messages/sensor_msgs.hpp"
#include "palpate/ros2/messages/std_msgs.hpp"

namespace palpate::bridge {

Qos sensor_qos(bool best_effort) {
  return {.reliable = !best_effort, .latched = false, .depth = 1000};
}

std::string refused_topics(const std::deque<RawReader>& readers) {
  std::string topics;
  for (const RawReader& reader : readers) {
    if (reader.refused() > 0) topics += (topics.empty() ? "" : ", ") + reader.topic();
  }
  return topics;
}

void add_stream_readers(Participant& participant, const hand::Description& hand,
                        const ros2::RobotInterface& interface, std::deque<RawReader>& readers) {
  const auto add = [&](const std::string& topic, std::string_view type, const Qos& qos) {
    readers.emplace_back(participant, topic, type, qos);
  };
  const Qos sensors = sensor_qos(interface.best_effort);
  const Qos latched{.reliable = true, .latched = true, .depth = 100};
  add(interface.tf_static, ros2::TFMessage::kType, latched);
  add(interface.tf, ros2::TFMessage::kType, sensors);
  for (const auto& finger : hand.fingers) {
    add(interface.contacts_of(finger), ros2::PointCloud2::kType, sensors);
    add(interface.fingertip_wrench_of(finger), ros2::WrenchStamped::kType, sensors);
    if (!interface.taxel_layout.contains(finger.name)) continue;
    add(interface.taxels_of(finger), ros2::Float64MultiArray::kType, sensors);
    add(interface.taxels_of(finger), ros2::Float32MultiArray::kType, sensors);
  }
  add(interface.wrench, ros2::WrenchStamped::kType, sensors);
  add(interface.actuator_states, ros2::JointState::kType, sensors);
  add(interface.joint_states, ros2::JointState::kType, sensors);
}

}  // namespace palpate::bridge
