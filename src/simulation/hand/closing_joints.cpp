// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/closing_joints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"
#include "simulation/hand/model_checks.hpp"

namespace palpate::simulation {
namespace {

constexpr double kAlike = 0.7;       // cosine between axes of joints that close a finger
constexpr double kTried = 0.3;       // rad
constexpr double kAlikeWays = 1e-3;  // m: neither way brings a tip nearer to the others
constexpr double kOpened = 0.02;     // m, by which a tip that is to close goes outwards

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

/// By how much nearer to a point an actuator moves its finger's tip by turning forwards, not
/// backwards, m.
double nearer_forwards(const hand::Description& hand, int actuator,
                       const hand::ActuatorVector& positions, const Eigen::Vector3d& goal) {
  const int finger = hand.actuators[static_cast<std::size_t>(actuator)].finger;
  const auto distance = [&](double by) {
    hand::ActuatorVector moved = positions;
    moved[actuator] += by;
    return (fingertips(hand, moved)[static_cast<std::size_t>(finger)] - goal).norm();
  };
  return distance(-kTried) - distance(kTried);
}

/// Middle of the tips of the fingers that a predicate holds for; not finite where there are none.
template <class Predicate>
Eigen::Vector3d middle_of_tips(const hand::Description& hand, const hand::ActuatorVector& positions,
                               const Predicate& is_meant) {
  const auto tips = fingertips(hand, positions);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    if (!is_meant(finger)) continue;
    sum += tips[static_cast<std::size_t>(finger)];
    ++count;
  }
  return sum / count;
}

/// Which way an actuator whose range does not determine it closes its finger: towards the straight
/// thumb, or a thumb's towards the middle of the others. Where both ways are alike, as on a flat
/// open hand: to where those fingers go that are known to close, or else forwards.
double towards_others(const hand::Description& hand, int actuator) {
  const int own = hand.actuators[static_cast<std::size_t>(actuator)].finger;
  const hand::ActuatorVector straight = partly_closed(hand, 0), half = partly_closed(hand, 0.5);
  const auto opposed = [&](int finger) { return (finger == hand.thumb) != (own == hand.thumb); };
  const auto known = [&](int finger) {
    return finger != own && std::ranges::any_of(hand.actuators, [&](const hand::Actuator& one) {
             return one.finger == finger && one.closing != 0;
           });
  };
  double nearer =
      nearer_forwards(hand, actuator, straight, middle_of_tips(hand, straight, opposed));
  if (std::abs(nearer) < kAlikeWays) {
    nearer = nearer_forwards(hand, actuator, half, middle_of_tips(hand, half, known));
  }
  return nearer < 0 ? -1 : 1;
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

std::string symmetric_joints(const hand::Description& hand) {
  hand::Description derived = hand;
  derive_closing(derived);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < hand.actuators.size(); ++i) {
    const hand::Actuator& one = hand.actuators[i];
    if (one.finger >= 0 && one.closing == 0 && derived.actuators[i].closing != 0) {
      names.push_back(one.name);
    }
  }
  if (names.empty()) return {};
  return fmt::format("joints {} have symmetric ranges: they close towards the other fingers",
                     first_of(names));
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
    const std::string& plain = hand.joints[static_cast<std::size_t>(joint)].name;
    const auto found = std::ranges::find_if(hand.actuators, [&](const hand::Actuator& one) {
      return std::ranges::count(one.joints, joint, &hand::DrivenJoint::joint) > 0;
    });
    if (found == hand.actuators.end() || found->finger < 0) {
      throw BadInput(fmt::format("closing: no actuator of a finger moves joint {}", plain));
    }
    if (found->joints.front().joint != joint) {
      throw BadInput(fmt::format("closing: joint {0} follows {1}; name {1}", plain, found->name));
    }
    if (found->closing != 0) throw BadInput(fmt::format("closing names {} twice", plain));
    found->closing = backwards ? -1 : 1;
  }
}

}  // namespace palpate::simulation
