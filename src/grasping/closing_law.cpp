// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/closing_law.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::grasping {

ClosingLaw::ClosingLaw(const hand::Description& hand, double rate,
                       const hand::ActuatorVector& closed) {
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const hand::Actuator& actuator = hand.actuators[static_cast<std::size_t>(i)];
    if (actuator.closing == 0 || actuator.finger < 0) continue;
    Drive drive{.actuator = i,
                .finger = static_cast<std::size_t>(actuator.finger),
                .stiffness = actuator.stiffness,
                .rate = std::abs(actuator.closing) * rate,
                .direction = actuator.closing > 0 ? 1.0 : -1.0,
                .range = actuator.command};
    if (drive.direction > 0) {
      drive.range.high = std::min(drive.range.high, closed[i]);
    } else {
      drive.range.low = std::max(drive.range.low, closed[i]);
    }
    drives_.push_back(drive);
  }
}

void ClosingLaw::advance(hand::HandCommand& command, const hand::HandReading& reading,
                         const hand::ActuatorVector& max_torque,
                         const hand::PerFinger<bool>& active) const {
  for (const Drive& drive : drives_) {
    if (!active[drive.finger]) continue;
    const int i = drive.actuator;
    const double pressing = drive.direction * reading.torques[i];
    const double lead = (max_torque[i] - pressing) / drive.stiffness;
    const double step = drive.direction * std::min(drive.rate * hand::kTick, lead);
    command.positions[i] =
        std::clamp(command.positions[i] + step, drive.range.low, drive.range.high);
  }
}

}  // namespace palpate::grasping
