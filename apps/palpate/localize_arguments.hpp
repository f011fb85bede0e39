// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common.hpp"

namespace palpate::app {

/// What `palpate localize` is given.
struct LocalizeArguments {
  CommonOptions common;
  std::string mesh, contacts;
  std::string method = "fast";
  bool demo = false, ignore_spin = false;
  double point_noise = 0.001, normal_noise_deg = 10, size_range = 0;
  std::optional<double> table;
  std::string free, planes, prior, units = "m";
};

/// The objects of MESH or MESH,MESH..; a file may have commas in its name.
std::vector<std::string> mesh_names(const std::string& meshes);

void add_localize_arguments(CLI::App& command, LocalizeArguments& arguments);

/// Refuses what does not go together. The demonstration runs on all processors unless told.
/// @throws CLI::ParseError
void check_localize_arguments(const CLI::App& command, LocalizeArguments& arguments);

}  // namespace palpate::app
