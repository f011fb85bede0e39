// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hand/descriptions.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::grasping {

/// A contact of the first finger.
inline tactile::Contact contact(const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
  tactile::Contact result;
  result.finger = 0;
  result.p = p;
  result.n = n.normalized();
  return result;
}

/// One finger with a coupled pair of hinges about z, 30 mm apart, whose tip is 20 mm further on.
inline hand::Description coupled_finger() {
  hand::Description hand = hand::shadow_on_link(2);
  hand.links.resize(3);
  const char* const joints[] = {"", "FFJ2", "FFJ1"};
  for (int i = 1; i < 3; ++i) {
    auto& link = hand.links[static_cast<std::size_t>(i)];
    link.parent = i - 1;
    link.axis = Eigen::Vector3d::UnitZ();
    link.joint = hand.joint(joints[i]);
    if (i == 2) link.T_parent_link.translation().x() = 0.03;
  }
  return hand;
}

}  // namespace palpate::grasping
