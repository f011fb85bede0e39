// SPDX-License-Identifier: Apache-2.0
#include "skills/grasp/closing_watch.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/hand/tip_forces.hpp"

namespace palpate::skills {
namespace {

constexpr double kTipContact = 0.10;  // N at which a finger counts as touching
constexpr int kLostTicks = 10;
constexpr int kSettlingTicks = 300;  // in which fingers that lose touch again and again may press
constexpr int kStillTicks = 12;
constexpr double kHeldUp = 0.6;        // of the contact torque, of a finger that is held up
constexpr int kHeldUpTicks = 10;       // for which it is
constexpr double kStillStep = 0.0003;  // rad a tick
constexpr int kSetOutTicks =
    20;  // of a closing in which nothing is met; friction from the latter half
constexpr double kSetOut =
    3;  // of the contact torque: limit then, and of friction that is believed

}  // namespace

bool ClosingFriction::known() const { return ticks_ >= kSetOutTicks; }

void ClosingFriction::update(const hand::HandReading& reading) {
  if (known() || ++ticks_ <= kSetOutTicks / 2) return;
  torques_ += reading.torques / static_cast<double>(kSetOutTicks - kSetOutTicks / 2);
}

hand::ActuatorVector ClosingFriction::limits(const hand::Description& hand,
                                             const hand::ActuatorVector& contact_torque) const {
  if (!known()) return kSetOut * contact_torque;
  hand::ActuatorVector limits = contact_torque;
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const double closing = hand.actuators[static_cast<std::size_t>(i)].closing;
    limits[i] += std::clamp(closing < 0 ? -torques_[i] : torques_[i], 0.0, kSetOut * limits[i]);
  }
  return limits;
}

FingersDone::FingersDone(const hand::Description& hand)
    : detectors_(hand.fingers.size(), TouchDetector(kTipContact)) {
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    const auto drives = hand::closing_actuators(hand, finger);
    drives_.push_back(drives.empty() ? -1 : drives.front());
  }
}

void FingersDone::update(const hand::HandReading& reading, const hand::HandCommand& command) {
  for (std::size_t finger = 0; finger < drives_.size(); ++finger) {
    const double position = drives_[finger] < 0 ? 0 : command.positions[drives_[finger]];
    const bool still = std::abs(position - last_[finger]) < kStillStep;
    still_[finger] = still && !done(finger) ? still_[finger] + 1 : 0;
    last_[finger] = position;
    const bool touches =
        detectors_[finger].update(hand::tip_force(reading, static_cast<int>(finger)));
    apart_[finger] = touches ? 0 : apart_[finger] + 1;
    touches_[finger] = touches || (touches_[finger] && apart_[finger] < kLostTicks);
    met_[finger] |= touches;
    stuck_[finger] = stuck_[finger] || still_[finger] > kStillTicks;
  }
  all_met_ = all_met_ || all();
  settled_ = all() ? settled_ + 1 : 0;
  since_all_met_ += all_met_;
}

bool FingersDone::settled() const {
  return settled_ > kLostTicks || since_all_met_ > kSettlingTicks;
}

bool FingersDone::all() const {
  for (std::size_t finger = 0; finger < drives_.size(); ++finger) {
    if (!done(finger)) return false;
  }
  return true;
}

hand::PerFinger<bool> FingersDone::still_closing() const {
  hand::PerFinger<bool> open{};
  for (std::size_t finger = 0; finger < drives_.size(); ++finger) open[finger] = !done(finger);
  return open;
}

bool UnsensedContacts::presses(const hand::HandReading& reading,
                               const hand::ActuatorVector& friction, int finger) const {
  if (!reading.contacts[static_cast<std::size_t>(finger)].empty()) return false;
  const auto drives = hand::closing_actuators(hand_, finger);
  return std::any_of(drives.begin(), drives.end(), [&](int i) {
    const double torque = reading.torques[i] - friction[i];
    const bool closes_up = hand_.actuators[static_cast<std::size_t>(i)].closing > 0;
    return (closes_up ? torque : -torque) > kHeldUp * contact_torque_[i];
  });
}

std::vector<int> UnsensedContacts::update(const hand::HandReading& reading,
                                          const hand::ActuatorVector& friction) {
  std::vector<int> fingers;
  for (int finger = 0; finger < hand_.finger_count(); ++finger) {
    int& held_up = held_up_[static_cast<std::size_t>(finger)];
    held_up = presses(reading, friction, finger) ? held_up + 1 : 0;
    if (held_up >= kHeldUpTicks) fingers.push_back(finger);
  }
  return fingers;
}

}  // namespace palpate::skills
