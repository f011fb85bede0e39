// SPDX-License-Identifier: Apache-2.0
#include "skills/safety/unsensed_force.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::skills {
namespace {

constexpr double kMisread = 0.1;    // of the largest torque: friction and error of what is read
constexpr double kNearLimit = 0.9;  // of the limit, from where the command follows slowly
constexpr int kApart = 10;   // readings without a contact, after which a fingertip senses nothing
constexpr int kHeldUp = 10;  // ticks in a row, of a finger that is limited

}  // namespace

double unsensed_torque(const hand::Actuator& actuator, double max_force) {
  return max_force * actuator.lever + kMisread * actuator.max_torque;
}

UnsensedForce::UnsensedForce(const hand::Description& hand, double max_force)
    : hand_(hand), max_torques_(hand::ActuatorVector::Zero(hand.actuator_count())) {
  for (int i = 0; i < hand.actuator_count(); ++i) {
    max_torques_[i] = unsensed_torque(hand.actuators[static_cast<std::size_t>(i)], max_force);
  }
}

std::vector<int> UnsensedForce::limit(hand::HandCommand& command, const hand::HandCommand& last,
                                      const hand::HandReading& reading) {
  hand::PerFinger<bool> limited{};
  for (std::size_t finger = 0; finger < hand_.fingers.size(); ++finger) {
    apart_[finger] = reading.contacts[finger].empty() ? apart_[finger] + 1 : 0;
  }
  for (int i = 0; i < hand_.actuator_count(); ++i) {
    const int finger = hand_.actuators[static_cast<std::size_t>(i)].finger;
    if (finger < 0 || apart_[static_cast<std::size_t>(finger)] < kApart) continue;
    limited[static_cast<std::size_t>(finger)] |= limit(i, command, last, reading);
  }
  std::vector<int> held_up;
  for (std::size_t finger = 0; finger < hand_.fingers.size(); ++finger) {
    pressed_[finger] = limited[finger] ? pressed_[finger] + 1 : 0;
    if (pressed_[finger] >= kHeldUp) held_up.push_back(static_cast<int>(finger));
  }
  return held_up;
}

/// The lead of the command on the joint is taken from the torque, as when closing. Near the limit
/// it may grow by no more than is left: a command that is wanted again and again stays limited.
/// @return whether the actuator is kept from pressing with more than it may
bool UnsensedForce::limit(int actuator, hand::HandCommand& command, const hand::HandCommand& last,
                          const hand::HandReading& reading) const {
  const double torque = reading.torques[actuator];
  const double max_torque = max_torques_[actuator];
  if (std::abs(torque) <= kNearLimit * max_torque) return false;
  const double stiffness = hand_.actuators[static_cast<std::size_t>(actuator)].stiffness;
  const double room = (max_torque - std::abs(torque)) / stiffness;
  double& position = command.positions[actuator];
  const double most = last.positions[actuator] + (torque > 0 ? room : -room);
  const double wanted = position;
  position = torque > 0 ? std::min(position, most) : std::max(position, most);
  return position != wanted || std::abs(torque) > max_torque;
}

}  // namespace palpate::skills
