// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <string>

#include "palpate/hand/kinematics.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Which of hand::kJointNames a joint of a model is, and which way round its axis is there.
struct NamedJoint {
  int joint;
  double sign;
};
using JointNamer = std::function<NamedJoint(const std::string& name)>;

/// A hand as data, from a compiled model.
/// @param root  body that the hand starts with; its own joints are left out
/// @param tips  geoms, one a finger: capsules along their links' z axes
/// @throws BadInput if there is no palm, or a link is not joined by one hinge at its origin
hand::HandModel read_hand_model(const mjModel& model, int root, const JointNamer& joint_of,
                                const std::array<int, hand::kFingers>& tips);

}  // namespace palpate::simulation
