// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/hand/description.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Names that links, joints and actuators of the hand have in its model file.
std::string file_link(const hand::Description& hand, std::string_view link);
std::string file_joint(const hand::Description& hand, std::string_view joint);
std::string file_actuator(const hand::Description& hand, std::string_view actuator);
/// What the names of all that is not of the hand's own file begin with: no file uses it.
constexpr const char* kOwnPrefix = "palpate:";
std::string own_name(const std::string& name);

/// @throws BadInput if the model has something of this name already
void set_name(mjsElement* element, const std::string& name);

/// Name of the geom that is a fingertip.
std::string tip_geom(const hand::Description& hand, int finger);

/// A model file (MJCF or URDF), parsed, without its options.
/// @param warnings  receives what the parser warns of, and links without a mass
/// @param kind  what it is a model of, for messages
/// @throws BadInput, naming the file and what is wrong with it
SpecHandle parse_model(const std::filesystem::path& file,
                       std::vector<std::string>* warnings = nullptr,
                       std::string_view kind = "hand");

/// Puts the hand's first body where the mount carries it.
void place_root(mjSpec& spec, const hand::ModelFile& file);

/// Makes the finger's capsule or hull of what its fingertip's body collides with.
/// @throws BadInput if there is no such body, or it has nothing to collide with
void put_tip(mjSpec& spec, const std::string& body, const std::string& geom,
             const hand::Finger& finger);

/// The hand of its model file, alone, with its root placed and its fingertips put in.
/// @throws BadInput, naming the file and what is wrong with it
SpecHandle parse_hand(const hand::Description& hand);

/// Names of a model's elements of a type.
std::vector<std::string> names_of(const mjSpec& spec, mjtObj type);

/// @throws BadInput if the model has no such body
mjsBody& find_body(const mjSpec& spec, const std::string& name);

/// The compiled model. @throws BadInput with the compiler's message
ModelHandle compile(mjSpec& spec);

/// Id of a named thing in the model. @throws BadInput if there is none
int find_id(const mjModel& model, mjtObj type, const std::string& name);

}  // namespace palpate::simulation
