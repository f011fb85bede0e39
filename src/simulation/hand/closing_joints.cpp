// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/closing_joints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::simulation {
namespace {

constexpr double kAlike = 0.7;  // cosine between axes of joints that close a finger

/// Axis of the first joint that an actuator moves, in the mount's frame.
Eigen::Vector3d axis_of(const hand::Description& hand, const hand::Actuator& actuator) {
  const auto T = hand::forward_kinematics(hand, hand::JointVector::Zero(hand.joint_count()));
  for (std::size_t i = 0; i < hand.links.size(); ++i) {
    if (hand.links[i].joint == actuator.joints.front().joint) {
      return T[i].linear() * hand.links[i].axis;
    }
  }
  return Eigen::Vector3d::Zero();
}

}  // namespace

void derive_closing(hand::Description& hand) {
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    std::vector<hand::Actuator*> own;
    for (auto& actuator : hand.actuators) {
      if (actuator.finger == finger) own.push_back(&actuator);
    }
    if (own.empty()) continue;
    const bool thumb = finger == hand.thumb;
    const Eigen::Vector3d last = axis_of(hand, *own.back());
    for (std::size_t i = 0; i < own.size(); ++i) {
      const bool alike = std::abs(axis_of(hand, *own[i]).dot(last)) > kAlike;
      const bool outer = i + 1 == own.size() || (thumb && alike && i + 2 == own.size());
      const auto& [low, high] = own[i]->command;
      if (outer && own[i]->closing == 0) own[i]->closing = high + low >= 0 ? 1 : -1;
      if (!outer && (thumb || !alike)) own[i]->closing = 0;
    }
  }
}

void set_closing(const std::vector<std::string>& joints, hand::Description& hand) {
  for (hand::Actuator& actuator : hand.actuators) actuator.closing = 0;
  for (const std::string& name : joints) {
    const bool backwards = name.starts_with('-');
    const int joint = hand.joint(backwards ? name.substr(1) : name);
    const auto found = std::ranges::find_if(hand.actuators, [&](const hand::Actuator& one) {
      return one.joints.front().joint == joint;
    });
    if (found == hand.actuators.end() || found->finger < 0) {
      throw BadInput(fmt::format("closing: no actuator of a finger moves joint {}", name));
    }
    found->closing = backwards ? -1 : 1;
  }
}

}  // namespace palpate::simulation
