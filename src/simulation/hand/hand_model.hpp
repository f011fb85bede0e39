// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "palpate/hand/description.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Which of a hand's joints a joint of a model is, and which way round its axis is there.
struct NamedJoint {
  int joint;
  double sign;
};
using JointNamer = std::function<NamedJoint(const std::string& name)>;

/// Joints of the body that a hand or an arm starts with: a hand's mount takes their place.
enum class RootJoints { left_out, kept };

/// Reads the links, palm, fingertips and surface of a hand from a compiled model.
/// @param root  body that the hand starts with
/// @param palm  body
/// @param tips  geoms, one a finger: capsules
/// @param hand  whose joints and fingers are known; gets the rest
/// @throws BadInput if there is no palm, or a link is joined by anything but hinges
void read_links(const mjModel& model, int root, const std::string& palm, const JointNamer& joint_of,
                const std::vector<int>& tips, hand::Description& hand,
                RootJoints root_joints = RootJoints::left_out);

/// The link of each of the hand's bodies, by body; -1 for other bodies.
std::vector<int> links_of_bodies(const mjModel& model, int root,
                                 RootJoints root_joints = RootJoints::left_out);

/// Gains and limits of the hand's actuators, as a compiled model has them.
void read_drives(const mjModel& model, hand::Description& hand);

}  // namespace palpate::simulation
