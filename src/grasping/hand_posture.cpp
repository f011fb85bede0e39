// SPDX-License-Identifier: Apache-2.0
#include "grasping/hand_posture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <sstream>
#include <vector>

namespace palpate::grasping {
namespace {

/// Of to_bytes, whatever the locale of the program.
double hexadecimal(std::string_view word) {
  const bool negative = word.starts_with('-');
  word.remove_prefix(std::min<std::size_t>(word.size(), negative ? 3 : 2));  // the sign, and 0x
  double value = 0;
  std::from_chars(word.data(), word.data() + word.size(), value, std::chars_format::hex);
  return negative ? -value : value;
}

}  // namespace

std::string fingerprint(const hand::Description& hand, std::string_view kind) {
  std::string text = "preshape 6";
  const auto add = [&](double value) { text += fmt::format(" {:a}", value); };
  for (const hand::Link& link : hand.links) {
    for (const double value : link.T_parent_link.matrix().reshaped()) add(value);
    for (const double value : link.axis) add(value);
    text += fmt::format(" {} {}", link.parent, link.joint);
  }
  for (const hand::Actuator& one : hand.actuators) {
    for (const double value : {one.command.low, one.command.high, one.closing, one.lever})
      add(value);
    for (const auto& driven : one.joints) {
      text += fmt::format(" {} {:a} {:a}", driven.joint, driven.share, driven.offset);
    }
    text += fmt::format(" {}", one.finger);
  }
  for (const hand::Finger& finger : hand.fingers) {
    for (const double value : finger.tip.a) add(value);
    for (const double value : finger.tip.b) add(value);
    add(finger.tip.radius);
    if (finger.hull) {
      for (const Eigen::Vector3d& p : finger.hull->core) {
        for (const double value : p) add(value);
      }
      add(finger.hull->radius);
    }
    text += fmt::format(" {}", finger.link);
  }
  for (const hand::LinkSphere& sphere : hand.spheres) {
    for (const double value : sphere.center) add(value);
    add(sphere.radius);
    text += fmt::format(" {}", sphere.link);
  }
  return text + fmt::format("{} {} {}", kind, hand.thumb, hand.palm);
}

std::string to_bytes(const HandPosture& best, const hand::Attitude& other) {
  std::string text =
      fmt::format("{:a} {:a} {:a} {:a} {:a} {:a} {:a} {:a} {:a}", best.attitude.pitch,
                  best.attitude.roll, other.pitch, other.roll, best.fingers[0], best.fingers[1],
                  best.thumb[0], best.thumb[1], best.curl);
  for (const double value : best.opposition) text += fmt::format(" {:a}", value);
  return text;
}

bool from_bytes(const std::string& bytes, int actuators, HandPosture& best, hand::Attitude& other) {
  constexpr std::size_t kOwn = 9;
  std::istringstream text(bytes);
  std::vector<double> values;
  for (std::string word; text >> word;) values.push_back(hexadecimal(word));
  if (values.size() != static_cast<std::size_t>(actuators) + kOwn) return false;
  best.attitude = {values[0], values[1]};
  other = {values[2], values[3]};
  best.fingers = {values[4], values[5]};
  best.thumb = {values[6], values[7]};
  best.curl = values[8];
  best.opposition = hand::ActuatorVector::Map(values.data() + kOwn, actuators);
  return true;
}

}  // namespace palpate::grasping
