// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/shadow.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

namespace palpate::hand {
namespace {

using Values = std::vector<std::pair<std::string_view, double>>;

constexpr std::array<std::string_view, 4> kLongFingers = {"FF", "MF", "RF", "LF"};

Range range_of_joint(std::string_view joint) {
  if (joint == "WRJ1") return {-0.698, 0.489};
  if (joint == "WRJ2") return {-0.489, 0.174};
  if (joint == "LFJ5") return {0.0, 0.785};
  if (joint == "THJ1") return {-0.262, 1.571};
  if (joint == "THJ2") return {-0.698, 0.698};
  if (joint == "THJ3") return {-0.209, 0.209};
  if (joint == "THJ4") return {0.0, 1.222};
  if (joint == "THJ5") return {-1.047, 1.047};
  switch (joint.back()) {
    case '4':
      return {-0.349, 0.349};
    case '3':
      return {-0.262, 1.571};
    default:
      return {0.0, 1.571};
  }
}

int finger_of(std::string_view name) {
  const auto found =
      std::find(kShadowFingerNames.begin(), kShadowFingerNames.end(), name.substr(0, 2));
  return found == kShadowFingerNames.end() ? -1
                                           : static_cast<int>(found - kShadowFingerNames.begin());
}

double closing_of(std::string_view name) {
  if (name == "THJ5") return 0.5;
  if (name == "THJ2") return 0.6;
  if (name == "THJ1") return 0.8;
  if (finger_of(name) < 1) return 0;
  return name.back() == '3' ? 1.0 : name.back() == '0' ? 1.2 : 0;
}

double lever_of(std::string_view name) {
  if (name.starts_with("WR")) return 0.18;
  if (name == "THJ1") return 0.035;
  if (name == "THJ2" || name == "THJ3") return 0.07;
  return name.back() == '0' ? 0.05 : 0.1;
}

Range bend_of(std::string_view name) {
  if (name == "THJ5") return {-0.5, 0.7};
  if (name == "THJ4") return {0.5, 1.2};
  if (name == "THJ2") return {-0.4, 0.6};
  if (name == "THJ1") return {0.0, 0.6};
  if (finger_of(name) < 1) return {};
  switch (name.back()) {
    case '4':
      return {-0.15, 0.15};
    case '3':
      return {0.0, 1.2};
    case '0':
      return {0.0, 1.8};
    default:
      return {};
  }
}

Actuator actuator_named(const Description& hand, std::string_view name) {
  Actuator actuator;
  actuator.name = name;
  if (name.back() == '0') {
    const std::string finger(name.substr(0, 3));
    actuator.joints = {{.joint = hand.joint(finger + "2")}, {.joint = hand.joint(finger + "1")}};
    actuator.coupling.emplace();
  } else {
    actuator.joints = {{.joint = hand.joint(name)}};
  }
  for (const DrivenJoint& driven : actuator.joints) {
    const Range range = hand.joints[static_cast<std::size_t>(driven.joint)].range;
    actuator.command.low += range.low;
    actuator.command.high += range.high;
  }
  actuator.finger = finger_of(name);
  actuator.closing = closing_of(name);
  actuator.lever = lever_of(name);
  actuator.bend = bend_of(name);
  return actuator;
}

/// The given actuators at their values, the others at 0.
ActuatorVector posture(const Description& hand, const Values& values) {
  ActuatorVector result = ActuatorVector::Zero(hand.actuator_count());
  for (const auto& [name, value] : values) result[hand.actuator(name)] = value;
  return result;
}

/// The thumb and the long fingers, but for one, out of the way.
ActuatorVector apart(const Description& hand, double knuckle, double middle,
                     std::string_view but_for = {}) {
  ActuatorVector result = posture(hand, {{"THJ5", -1.0}, {"THJ2", -0.6}});
  for (const std::string_view finger : kLongFingers) {
    if (finger == but_for) continue;
    result[hand.actuator(std::string(finger) + "J3")] = knuckle;
    result[hand.actuator(std::string(finger) + "J0")] = middle;
  }
  return result;
}

FlatHand flat_hand(const Description& hand) {
  // With the forearm raised, these angles of wrist and knuckles make the underside of the fingers
  // and of the palm's front one level plane.
  return {posture(hand, {{"WRJ1", -0.25},
                         {"THJ5", -1.0},
                         {"THJ2", -0.5},
                         {"FFJ3", -0.25},
                         {"MFJ3", -0.25},
                         {"RFJ3", -0.25},
                         {"LFJ3", -0.25}}),
          {.pitch = 0.5, .roll = 0},
          {0.072, -0.005}};
}

std::vector<PointingHand> pointing_hands(const Description& hand) {
  constexpr Attitude kDown = {.pitch = 1.35, .roll = 0};
  std::vector<PointingHand> hands;
  for (const int finger : {1, 2, 3}) {
    const auto name = kShadowFingerNames[static_cast<std::size_t>(finger)];
    hands.push_back({finger, apart(hand, 1.4, 2.6, name), kDown});
  }
  return hands;
}

/// What distinguishes one preshape from the other.
struct Fingers {
  double proximal, distal, spread, thumb_base, thumb_opposition, thumb_middle;
  double thumb_end;                   ///< largest THJ5
  double knuckle_torque, tip_torque;  ///< N m
};

Preshape preshape_of(const Description& hand, const Fingers& fingers) {
  Preshape preshape;
  preshape.open = posture(hand, {{"FFJ4", -fingers.spread},
                                 {"LFJ4", -fingers.spread},
                                 {"LFJ5", 0.1},
                                 {"THJ5", fingers.thumb_base},
                                 {"THJ4", fingers.thumb_opposition},
                                 {"THJ2", fingers.thumb_middle}});
  preshape.closed = preshape.contact_torque = ActuatorVector::Zero(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const Actuator& actuator = hand.actuators[static_cast<std::size_t>(i)];
    preshape.closed[i] = actuator.command.high;
    const bool tip = actuator.name == "THJ1" || actuator.coupling;
    preshape.contact_torque[i] = tip ? fingers.tip_torque : fingers.knuckle_torque;
  }
  for (const std::string_view finger : kLongFingers) {
    preshape.open[hand.actuator(std::string(finger) + "J3")] = fingers.proximal;
    preshape.open[hand.actuator(std::string(finger) + "J0")] = fingers.distal;
  }
  preshape.closed[hand.actuator("THJ5")] = fingers.thumb_end;
  return preshape;
}

Preshape top_preshape(const Description& hand) {
  Preshape preshape = preshape_of(hand, {.proximal = 0.094,
                                         .distal = 0.540,
                                         .spread = 0.087,
                                         .thumb_base = -0.20,
                                         .thumb_opposition = 1.03,
                                         .thumb_middle = -0.21,
                                         .thumb_end = 0.718,
                                         .knuckle_torque = 0.117,
                                         .tip_torque = 0.082});
  preshape.attitudes = {
      {.pitch = 0.475, .roll = -0.30}, {.pitch = 0.3, .roll = 0.0}, {.pitch = 0.9, .roll = -0.30}};
  preshape.offset = {-0.005, -0.030};
  return preshape;
}

Preshape side_preshape(const Description& hand) {
  Preshape preshape = preshape_of(hand, {.proximal = 0.175,
                                         .distal = 0.328,
                                         .spread = 0.18,
                                         .thumb_base = -0.30,
                                         .thumb_opposition = 1.08,
                                         .thumb_middle = -0.34,
                                         .thumb_end = 0.785,
                                         .knuckle_torque = 0.098,
                                         .tip_torque = 0.069});
  preshape.attitudes = {{.pitch = 0.197, .roll = std::numbers::pi / 2 - 0.017}};
  preshape.offset = {0.002, 0};
  preshape.height = 0.073;
  return preshape;
}

Description make_shadow_hand() {
  Description hand;
  hand.name = "shadow";
  for (const auto name : kShadowJointNames) {
    hand.joints.push_back({std::string(name), range_of_joint(name)});
  }
  for (const auto name : kShadowFingerNames) hand.fingers.push_back({std::string(name), -1, {}});
  for (const auto name : kShadowActuatorNames) {
    hand.actuators.push_back(actuator_named(hand, name));
  }
  Postures& postures = hand.postures;
  postures.flat = flat_hand(hand);
  postures.pointing = pointing_hands(hand);
  postures.stretched = apart(hand, -0.2, 0.0);
  postures.folded = apart(hand, 1.4, 2.6);
  postures.released = ActuatorVector::Constant(hand.actuator_count(), 0.1);
  postures.top = top_preshape(hand);
  postures.side = side_preshape(hand);
  // Rolled far, the hand still clears the table when it stands up what lay on its side; farther
  // still, when it lays down what stood.
  postures.far_attitudes = {{.pitch = 0.9, .roll = -0.8}, {.pitch = 0.9, .roll = -1.2}};
  return hand;
}

}  // namespace

const Description& shadow_hand() {
  static const Description hand = make_shadow_hand();
  return hand;
}

}  // namespace palpate::hand
