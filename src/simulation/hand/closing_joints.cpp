// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/closing_joints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::simulation {
namespace {

constexpr double kAlike = 0.7;    // cosine between axes of joints that close a finger
constexpr double kTried = 0.3;    // rad
constexpr double kOpened = 0.02;  // m, by which a tip that is to close goes outwards

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

/// Which way an actuator whose range does not determine it closes its finger: towards the thumb's
/// tip; that of a thumb towards the middle of the others. All else is straight.
double towards_others(const hand::Description& hand, int actuator) {
  hand::ActuatorVector positions(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    positions[i] = hand::straight_command(hand.actuators[static_cast<std::size_t>(i)]);
  }
  const int finger = hand.actuators[static_cast<std::size_t>(actuator)].finger;
  const auto straight = fingertips(hand, positions);
  Eigen::Vector3d goal = Eigen::Vector3d::Zero();
  for (int other = 0; other < hand.finger_count(); ++other) {
    const double fingers = hand.finger_count() - 1;
    const bool thumb = other == hand.thumb;
    const double share = finger == hand.thumb ? (thumb ? 0 : 1 / fingers) : thumb;
    goal += share * straight[static_cast<std::size_t>(other)];
  }
  const auto distance = [&](double by) {
    hand::ActuatorVector moved = positions;
    moved[actuator] += by;
    return (fingertips(hand, moved)[static_cast<std::size_t>(finger)] - goal).norm();
  };
  return distance(kTried) <= distance(-kTried) ? 1 : -1;
}

/// Where a finger begins, m: at the first of its joints that close it.
Eigen::Vector3d base_of(const hand::Description& hand, int finger,
                        const hand::ActuatorVector& positions) {
  const int first = hand::closing_actuators(hand, finger).front();
  const int joint = hand.actuators[static_cast<std::size_t>(first)].joints.front().joint;
  const auto T = hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, positions));
  const auto link = std::ranges::find(hand.links, joint, &hand::Link::joint);
  return T[static_cast<std::size_t>(link - hand.links.begin())].translation();
}

/// Whether the first actuator of a finger moves its tip away from the fingers on the other side
/// where it is expected to close. Outer joints may curl a tip round and outwards.
bool is_reversed(const hand::Description& hand, int finger) {
  const int first = hand::closing_actuators(hand, finger).front();
  hand::ActuatorVector middle(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const auto& [low, high] = hand.actuators[static_cast<std::size_t>(i)].command;
    middle[i] = 0.5 * (low + high);
  }
  Eigen::Vector3d outwards = Eigen::Vector3d::Zero();
  for (int other = 0; other < hand.finger_count(); ++other) {
    if ((other == hand.thumb) == (finger == hand.thumb)) continue;
    outwards += base_of(hand, finger, middle) - base_of(hand, other, middle);
  }
  outwards.normalize();
  const auto out = [&](double command) {
    hand::ActuatorVector positions = middle;
    positions[first] = command;
    return fingertips(hand, positions)[static_cast<std::size_t>(finger)].dot(outwards);
  };
  const hand::Actuator& one = hand.actuators[static_cast<std::size_t>(first)];
  return out(hand::closed_command(one)) - out(hand::straight_command(one)) > kOpened;
}

std::vector<int> actuators_of(const hand::Description& hand, int finger) {
  std::vector<int> own;
  for (int i = 0; i < hand.actuator_count(); ++i) {
    if (hand.actuators[static_cast<std::size_t>(i)].finger == finger) own.push_back(i);
  }
  return own;
}

}  // namespace

std::vector<Eigen::Vector3d> fingertips(const hand::Description& hand,
                                        const hand::ActuatorVector& positions) {
  const auto T = hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, positions));
  std::vector<Eigen::Vector3d> tips;
  for (const hand::Finger& finger : hand.fingers) {
    tips.push_back(T[static_cast<std::size_t>(finger.link)] * finger.tip.b);
  }
  return tips;
}

bool ranges_determine_closing(const hand::Description& hand) {
  std::vector<bool> has_closing(static_cast<std::size_t>(hand.finger_count()));
  for (const hand::Actuator& one : hand.actuators) {
    if (one.finger >= 0 && one.closing != 0)
      has_closing[static_cast<std::size_t>(one.finger)] = true;
  }
  return std::ranges::all_of(has_closing, std::identity());
}

void derive_closing(hand::Description& hand) {
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    const std::vector<int> own = actuators_of(hand, finger);
    if (own.empty()) continue;
    const auto one = [&](std::size_t i) -> hand::Actuator& {
      return hand.actuators[static_cast<std::size_t>(own[i])];
    };
    const Eigen::Vector3d last = axis_of(hand, one(own.size() - 1));
    for (std::size_t i = 0; i < own.size(); ++i) {
      const bool alike = std::abs(axis_of(hand, one(i)).dot(last)) > kAlike;
      const bool bends = finger == hand.thumb ? alike && i + 2 >= own.size() : alike;
      if (!bends) one(i).closing = 0;
      if (bends && one(i).closing == 0) one(i).closing = towards_others(hand, own[i]);
    }
  }
}

bool reverse_if_closed_at_zero(hand::Description& hand) {
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    if (hand::closing_actuators(hand, finger).empty()) return false;
  }
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    if (!is_reversed(hand, finger)) return false;
  }
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    const int first = hand::closing_actuators(hand, finger).front();
    double& closing = hand.actuators[static_cast<std::size_t>(first)].closing;
    closing = -closing;
  }
  return true;
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
