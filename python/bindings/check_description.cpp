// SPDX-License-Identifier: Apache-2.0
#include "check_description.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <string_view>

#include "palpate/core/error.hpp"

namespace palpate::python {
namespace {

void check_index(int index, int least, std::size_t count, std::string_view what) {
  if (index >= least && index < static_cast<int>(count)) return;
  throw BadInput(fmt::format("{} of a hand is {}, not {} to {}", what, index, least,
                             static_cast<int>(count) - 1));
}

void check_count(std::size_t count, int most, std::string_view what) {
  if (count >= 1 && count <= static_cast<std::size_t>(most)) return;
  throw BadInput(fmt::format("a hand of {} {}, not 1 to {}", count, what, most));
}

void check_links(const hand::Description& hand) {
  for (std::size_t i = 0; i < hand.links.size(); ++i) {
    check_index(hand.links[i].parent, -1, i, "the parent of a link");
    check_index(hand.links[i].joint, -1, hand.joints.size(), "the joint of a link");
  }
  check_index(hand.palm, -1, hand.links.size(), "the palm");
  for (const auto& sphere : hand.spheres) {
    check_index(sphere.link, 0, hand.links.size(), "the link of a sphere");
  }
}

void check_fingers(const hand::Description& hand) {
  for (const auto& finger : hand.fingers) {
    check_index(finger.link, 0, hand.links.size(), "the link of a fingertip");
    if (finger.hull && finger.hull->core.empty()) {
      throw BadInput(fmt::format("the hull of {} has 0 corners", finger.name));
    }
  }
  check_index(hand.thumb, 0, hand.fingers.size(), "the thumb");
}

void check_actuators(const hand::Description& hand) {
  for (const auto& actuator : hand.actuators) {
    check_index(actuator.finger, -1, hand.fingers.size(), "the finger of an actuator");
    for (const auto& driven : actuator.joints) {
      check_index(driven.joint, 0, hand.joints.size(), "the joint of an actuator");
    }
    if (actuator.coupling && actuator.joints.size() != 2) {
      throw BadInput(
          fmt::format("{} couples {} joints, not 2", actuator.name, actuator.joints.size()));
    }
  }
}

/// One value an actuator; none where the hand has no such posture.
void check_posture(const hand::ActuatorVector& posture, const hand::Description& hand) {
  if (posture.size() == 0 || posture.size() == hand.actuator_count()) return;
  throw BadInput(fmt::format("a posture of {} values, the hand has {} actuators", posture.size(),
                             hand.actuator_count()));
}

void check_preshape(const hand::Preshape& preshape, const hand::Description& hand) {
  check_posture(preshape.open, hand);
  check_posture(preshape.closed, hand);
  check_posture(preshape.contact_torque, hand);
  if (preshape.open.size() > 0 && preshape.attitudes.empty()) {
    throw BadInput("a preshape of a hand has 0 attitudes");
  }
}

void check_postures(const hand::Description& hand) {
  const hand::Postures& postures = hand.postures;
  for (const auto* posture :
       {&postures.flat.positions, &postures.stretched, &postures.folded, &postures.released}) {
    check_posture(*posture, hand);
  }
  for (const auto& one : postures.pointing) {
    check_index(one.finger, 0, hand.fingers.size(), "a pointing finger");
    check_posture(one.positions, hand);
  }
  check_preshape(postures.top, hand);
  check_preshape(postures.side, hand);
}

}  // namespace

void check_description(const hand::Description& hand) {
  check_count(hand.joints.size(), hand::kMaxJoints, "joints");
  check_count(hand.actuators.size(), hand::kMaxJoints, "actuators");
  check_count(hand.fingers.size(), hand::kMaxFingers, "fingers");
  check_links(hand);
  check_fingers(hand);
  check_actuators(hand);
  check_postures(hand);
}

}  // namespace palpate::python
