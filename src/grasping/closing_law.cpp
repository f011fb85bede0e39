// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/closing_law.hpp"

#include <algorithm>
#include <string>

namespace palpate::grasping {
namespace {

// Speeds of the closing joints relative to J3.
constexpr double kDistalRatio = 1.2;
constexpr double kThumbBaseRatio = 0.5;
constexpr double kThumbMiddleRatio = 0.6;
constexpr double kThumbDistalRatio = 0.8;

}  // namespace

ClosingTorque blend(const ClosingTorque& a, const ClosingTorque& b, double share) {
  const auto mix = [share](double from, double to) { return from + share * (to - from); };
  return {mix(a.proximal, b.proximal), mix(a.distal, b.distal), mix(a.thumb, b.thumb),
          mix(a.thumb_distal, b.thumb_distal)};
}

ClosingLaw::ClosingLaw(const std::array<hand::Actuator, hand::kActuators>& actuators, double rate,
                       double thumb_limit)
    : actuators_(actuators) {
  const auto add = [&](const std::string& name, double ratio, double ClosingTorque::*limit) {
    const int index = hand::actuator_index(name);
    drives_.push_back({index, hand::finger_of_actuator(index), ratio * rate,
                       actuators[static_cast<std::size_t>(index)].command, limit});
  };
  for (const char* finger : {"FF", "MF", "RF", "LF"}) {
    add(finger + std::string("J3"), 1.0, &ClosingTorque::proximal);
    add(finger + std::string("J0"), kDistalRatio, &ClosingTorque::distal);
  }
  add("THJ5", kThumbBaseRatio, &ClosingTorque::thumb);
  drives_.back().range.high = std::min(drives_.back().range.high, thumb_limit);
  add("THJ2", kThumbMiddleRatio, &ClosingTorque::thumb);
  add("THJ1", kThumbDistalRatio, &ClosingTorque::thumb_distal);
}

void ClosingLaw::advance(hand::HandCommand& command, const hand::HandReading& reading,
                         const ClosingTorque& limit,
                         const std::array<bool, hand::kFingers>& active) const {
  for (const Drive& drive : drives_) {
    if (!active[static_cast<std::size_t>(drive.finger)]) continue;
    const double stiffness = actuators_[static_cast<std::size_t>(drive.actuator)].stiffness;
    double& position = command.positions[drive.actuator];
    const double lead = (limit.*drive.limit - reading.torques[drive.actuator]) / stiffness;
    position = std::clamp(position + std::min(drive.rate * hand::kTick, lead), drive.range.low,
                          drive.range.high);
  }
}

}  // namespace palpate::grasping
