// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "palpate/hand/joints.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// What the names of the right hand's bodies, joints and actuators start with.
inline constexpr std::string_view kRight = "rh_";
inline constexpr double kTipRadius = 0.007;  ///< m

/// Names in the MJCF of a joint, of an actuator, of a fingertip's link and of its capsule.
std::string mjcf_joint(std::string_view joint);
std::string mjcf_actuator(std::string_view actuator);
std::string mjcf_distal(int finger);
std::string mjcf_tip(int finger);

/// The Shadow hand's MJCF, parsed, with BioTac-like capsules for fingertips and its root placed so
/// that the base's origin is where the hand grasps: palm down, fingers along +x, thumb side +y.
/// @throws BadInput, naming the file and what is wrong with it
SpecHandle parse_shadow_hand(const std::filesystem::path& mjcf);

/// @throws BadInput if the model has no such body
mjsBody& find_body(const mjSpec& spec, const std::string& name);

/// The compiled model. @throws BadInput with the compiler's message
ModelHandle compile(mjSpec& spec);

/// Id of a named thing in the model. @throws BadInput if there is none
int find_id(const mjModel& model, mjtObj type, const std::string& name);

}  // namespace palpate::simulation
