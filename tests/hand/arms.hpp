// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include "palpate/hand/arm.hpp"

namespace palpate::hand {

/// Six hinges, of which the last holds the hand with its palm down.
inline ArmDescription six_hinges() {
  const auto offset = [](double z) { return Eigen::Isometry3d(Eigen::Translation3d(0, 0, z)); };
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  ArmDescription arm;
  arm.name = "six hinges";
  arm.links = {{"base", -1, offset(0.3), z, 0}, {"upper", 0, offset(0), y, 1},
               {"fore", 1, offset(0.5), y, 2},  {"wrist_1", 2, offset(0.5), z, 3},
               {"wrist_2", 3, offset(0), y, 4}, {"wrist_3", 4, offset(0.1), z, 5}};
  for (const char* name : {"pan", "lift", "elbow", "roll", "pitch", "turn"}) {
    arm.joints.push_back({name, {-6.2, 6.2}});
  }
  arm.flange = 5;
  arm.T_world_stand.translation() << -0.6, 0, 0;
  arm.T_flange_mount.linear() =
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return arm;
}

}  // namespace palpate::hand
