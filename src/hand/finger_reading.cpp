// SPDX-License-Identifier: Apache-2.0
#include "hand/finger_reading.hpp"

namespace palpate::hand {
namespace {

std::vector<JointReading> joints_of(const HandReading& reading, std::string_view prefix) {
  std::vector<JointReading> joints;
  for (int i = 0; i < kJoints; ++i) {
    const std::string_view name = kJointNames[static_cast<std::size_t>(i)];
    if (name.starts_with(prefix)) joints.push_back({name, reading.joints[i]});
  }
  return joints;
}

std::vector<DriveReading> drives_of(const HandReading& reading, std::string_view prefix) {
  std::vector<DriveReading> drives;
  for (int i = 0; i < kActuators; ++i) {
    const std::string_view name = kActuatorNames[static_cast<std::size_t>(i)];
    if (name.starts_with(prefix)) drives.push_back({name, reading.torques[i]});
  }
  return drives;
}

}  // namespace

FingerReading finger_reading(const HandReading& reading, Finger finger) {
  const auto index = static_cast<std::size_t>(finger);
  const std::string_view prefix = kFingerNames.at(index);
  return {reading.time, joints_of(reading, prefix), drives_of(reading, prefix),
          reading.contacts[index]};
}

WristReading wrist_reading(const HandReading& reading) {
  return {reading.time, joints_of(reading, "WR"), drives_of(reading, "WR")};
}

}  // namespace palpate::hand
