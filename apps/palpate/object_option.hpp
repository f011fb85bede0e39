// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "palpate/estimation/estimate.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/geometry/objects/known_object.hpp"

namespace palpate::app {

/// What is given of an object beside its shape.
struct ObjectArguments {
  std::optional<double> mass;  ///< kg
  std::string at;              ///< X,Y[,R], m
  std::string units = "m";     ///< of mesh files
  double size_range = 0;       ///< share by which the object may be larger or smaller
};

/// --size-range R, which makes several candidates of each object.
CLI::Option* add_size_range_option(CLI::App& command, double& size_range);

/// The names and, after them, those of their other sizes within a range: "mug@0.95".
std::vector<std::string> with_sizes(const std::vector<std::string>& names, double size_range);

/// --units m|mm, of the mesh files.
void add_units_option(CLI::App& command, std::string& units);

/// The object of that name, or of that mesh file in these units.
/// @throws BadInput as geometry::load_known_object
geometry::KnownObject load_object(const std::string& name, const std::string& units);

/// @throws BadInput if these units are of mesh files, and none of the names is one
void require_mesh_file(const std::vector<std::string>& names, const std::string& units);

/// A line for each thing that was done to a mesh.
void print_repairs(const std::string& name, const std::vector<std::string>& repairs);

void add_object_options(CLI::App& command, ObjectArguments& arguments);

/// The object of that name or file, of the mass that was given.
/// @throws BadInput as geometry::load_known_object
geometry::KnownObject load_object(const std::string& name, const ObjectArguments& arguments);

/// What an object is called in the names of folders: a mesh file without its folder and ending,
/// with the size that its name states.
std::string short_name(const std::string& name);

/// Whether two names are of the same object: the same name, or the same mesh file.
bool is_same_object(const std::string& a, const std::string& b);

/// @throws BadInput for an object that is given twice
void require_distinct(const std::vector<std::string>& names);

/// The objects of these names, prepared for the search.
/// @throws BadInput as load_object, and for files of one name that would be taken for sizes
std::vector<geometry::ObjectModel> load_models(const std::vector<std::string>& names,
                                               const ObjectArguments& arguments);

/// Objects by their names, of which one may be what the hand touches; those given, then their other
/// sizes.
struct CandidateObjects {
  std::vector<std::string> names;
  std::vector<geometry::ObjectModel> models;

  [[nodiscard]] estimation::Candidates candidates() const;
  /// @return none if the object is not among them
  [[nodiscard]] const geometry::ObjectModel* find(const std::string& name) const;
};

/// @throws BadInput as load_object, for more than kMaxCandidates, and as require_distinct
CandidateObjects load_objects(const std::vector<std::string>& names,
                              const ObjectArguments& arguments);

/// Puts the rough place that was given into the options.
/// @param settings  of --set
/// @throws BadInput for a text that is no place, or one out of reach, and for an R that an option
///         states otherwise
void apply_place(const ObjectArguments& arguments, const std::vector<std::string>& settings,
                 evaluation::StartOptions& start);

}  // namespace palpate::app
