// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/joints.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/error.hpp"

namespace palpate::hand {
namespace {

template <std::size_t N>
int index_of(const std::array<std::string_view, N>& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw BadInput(fmt::format("no joint or actuator is named {}", name));
  return static_cast<int>(found - names.begin());
}

Range shadow_range(std::string_view joint) {
  if (joint == "WRJ1") return {-0.698, 0.489};
  if (joint == "WRJ2") return {-0.489, 0.174};
  if (joint == "LFJ5") return {0.0, 0.785};
  if (joint == "THJ1") return {-0.262, 1.571};
  if (joint == "THJ2") return {-0.698, 0.698};
  if (joint == "THJ3") return {-0.209, 0.209};
  if (joint == "THJ4") return {0.0, 1.222};
  if (joint == "THJ5") return {-1.047, 1.047};
  switch (joint.back()) {
    case '4':
      return {-0.349, 0.349};
    case '3':
      return {-0.262, 1.571};
    default:
      return {0.0, 1.571};
  }
}

}  // namespace

int joint_index(std::string_view name) { return index_of(kJointNames, name); }

int actuator_index(std::string_view name) { return index_of(kActuatorNames, name); }

int finger_of_actuator(int actuator) {
  const auto prefix = kActuatorNames.at(static_cast<std::size_t>(actuator)).substr(0, 2);
  const auto found = std::find(kFingerNames.begin(), kFingerNames.end(), prefix);
  return found == kFingerNames.end() ? -1 : static_cast<int>(found - kFingerNames.begin());
}

ActuatorVector actuator_positions(const JointVector& joints) {
  ActuatorVector positions;
  int joint = 0;
  for (int actuator = 0; actuator < kActuators; ++actuator) {
    const bool coupled = kActuatorNames[static_cast<std::size_t>(actuator)].back() == '0';
    positions[actuator] = coupled ? joints[joint] + joints[joint + 1] : joints[joint];
    joint += coupled ? 2 : 1;
  }
  return positions;
}

const std::array<Range, kJoints>& shadow_ranges() {
  static const auto ranges = [] {
    std::array<Range, kJoints> table{};
    std::transform(kJointNames.begin(), kJointNames.end(), table.begin(), shadow_range);
    return table;
  }();
  return ranges;
}

}  // namespace palpate::hand
