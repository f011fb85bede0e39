// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>

#include "hand/descriptions.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::hand {

/// A hand that is at once where it is commanded; a script says what it senses. As those of any
/// sensor its readings never repeat bit for bit.
class FakeHand : public hand::Hand {
 public:
  using Script = std::function<void(hand::HandReading&)>;

  explicit FakeHand(Script script = {}, Description model = shadow_hand())
      : script_(std::move(script)), model_(std::move(model)) {}

  hand::HandReading step(const hand::HandCommand& command) override {
    hand::HandReading reading = resting_reading(model_);
    reading.time = ++ticks_ * hand::kTick;
    reading.mount = command.mount;
    reading.joints = hand::joints_in_free_flexion(model_, command.positions);
    if (script_) script_(reading);
    ripple(reading);
    return reading;
  }

 private:
  void ripple(hand::HandReading& reading) const {
    const double ripple = ticks_ % 2 == 0 ? 1e-12 : 0;
    reading.joints[0] += ripple;
    reading.torques[0] += ripple;
    reading.mount_force.x() += ripple;
    for (auto& contacts : reading.contacts) {
      for (auto& contact : contacts) contact.p.x() += ripple;
    }
  }

  Script script_;
  Description model_;
  int ticks_ = 0;
};

}  // namespace palpate::hand
