// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "experiment.hpp"
#include "palpate/core/random.hpp"
#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/localization/evidence.hpp"

namespace palpate::experiment {

/// An object, the seeds of its scenes, and what makes them.
struct SearchSubject {
  SearchSubject(std::string its_name, std::uint64_t seed, int its_scenes);
  std::string name;
  geometry::ObjectModel model;
  geometry::MeshQuery mesh;
  std::uint64_t first_seed;
  int scenes;
};
using SearchSubjects = std::vector<std::unique_ptr<SearchSubject>>;

/// Generated shapes, the first of the seed of the options.
SearchSubjects generated_subjects(const Options& options, int shapes, int scenes);

/// The scans of the folder PALPATE_DATA/ycb, if there is one.
SearchSubjects scanned_subjects(const Options& options, int scenes);

enum class SearchMethod { fast, full };
std::string_view to_string(SearchMethod method);

/// What became of one search.
struct SearchOutcome {
  double stated = 0;     ///< probability of the best pose
  bool right = false;    ///< it is within 5 deg and 10 mm, modulo symmetry
  bool covered = false;  ///< the truth is in the smallest set of poses that holds 95 %
  double set_mass = 0;   ///< of that set, as stated; 0 without a pose
  bool certain = false;  ///< as its status says
  bool no_pose = false;
  double seconds = 0;  ///< of the processor
};
using SearchOutcomes = std::vector<SearchOutcome>;

SearchOutcome search_pose(const SearchSubject& subject, const localization::Evidence& evidence,
                          const Eigen::Isometry3d& truth, SearchMethod method,
                          const RandomStream& random);

/// Columns of a table of search_row()s, after those that name the row.
std::vector<std::string> search_columns(std::vector<std::string> names);
std::vector<std::string> search_row(std::vector<std::string> names, const SearchOutcomes& outcomes);

}  // namespace palpate::experiment
