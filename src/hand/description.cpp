// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/description.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/error.hpp"

namespace palpate::hand {
namespace {

template <class Named>
int index_of(const std::vector<Named>& all, std::string_view name, std::string_view kind) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Named& one) { return one.name == name; });
  if (found == all.end()) throw BadInput(fmt::format("the hand has no {} named '{}'", kind, name));
  return static_cast<int>(found - all.begin());
}

}  // namespace

int Description::joint(std::string_view named) const { return index_of(joints, named, "joint"); }

int Description::actuator(std::string_view named) const {
  return index_of(actuators, named, "actuator");
}

int Description::middle_finger() const {
  std::vector<int> others;
  for (int finger = 0; finger < finger_count(); ++finger) {
    if (finger != thumb) others.push_back(finger);
  }
  return others.empty() ? thumb : others[(others.size() - 1) / 2];
}

double straight_command(const Actuator& actuator) {
  constexpr double kLeastWay = 0.2;  // share of the range from straight to closed
  const auto& [low, high] = actuator.command;
  const double way = kLeastWay * (high - low);
  if (actuator.closing > 0 && high < way) return low;
  if (actuator.closing < 0 && low > -way) return high;
  return std::clamp(0.0, low, high);
}

double closed_command(const Actuator& actuator) {
  return actuator.closing > 0 ? actuator.command.high : actuator.command.low;
}

std::vector<int> closing_actuators(const Description& hand, int finger) {
  std::vector<int> closing;
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const Actuator& actuator = hand.actuators[static_cast<std::size_t>(i)];
    if (actuator.finger == finger && actuator.closing != 0) closing.push_back(i);
  }
  return closing;
}

std::optional<int> spreading_actuator(const Description& hand, int finger) {
  std::optional<int> spreading;
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const Actuator& actuator = hand.actuators[static_cast<std::size_t>(i)];
    if (actuator.finger != finger) continue;
    if (actuator.closing != 0) break;
    spreading = i;
  }
  return spreading;
}

}  // namespace palpate::hand
