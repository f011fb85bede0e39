// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>

#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::hand {

/// A hand that is at once where it is commanded; a script says what it feels. As those of any
/// sensor its readings never repeat bit for bit.
class FakeHand : public hand::Hand {
 public:
  using Script = std::function<void(hand::HandReading&)>;

  explicit FakeHand(Script script = {}) : script_(std::move(script)) {
    for (auto& actuator : actuators_) actuator = {1.0, {-1.5, 3.2}, 1.0};
  }

  const std::vector<hand::Actuator>& actuators() const override { return actuators_; }

  hand::HandReading step(const hand::HandCommand& command) override {
    hand::HandReading reading;
    reading.time = ++ticks_ * hand::kTick;
    reading.base = command.base;
    reading.joints = hand::joints_in_free_flexion(command.positions);
    if (script_) script_(reading);
    ripple(reading);
    return reading;
  }

 private:
  void ripple(hand::HandReading& reading) const {
    const double ripple = ticks_ % 2 == 0 ? 1e-12 : 0;
    reading.joints[0] += ripple;
    reading.torques[0] += ripple;
    reading.base_force.x() += ripple;
    for (auto& contacts : reading.contacts) {
      for (auto& contact : contacts) contact.p.x() += ripple;
    }
  }

  std::vector<hand::Actuator> actuators_;
  Script script_;
  int ticks_ = 0;
};

}  // namespace palpate::hand
