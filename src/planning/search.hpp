// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/planning/planner.hpp"
#include "planning/free_space.hpp"

namespace palpate::planning {

/// What a search may change of a configuration.
struct SearchSpace {
  std::vector<int> moving;  ///< coordinates, not empty
  Coordinates low, high;    ///< bounds of each moving coordinate
};

struct PathSearchOptions {
  PlannerKind planner = PlannerKind::rrt_connect;
  int iterations = 10000;
  int shortenings = 100;
};

/// Vertices of a polyline from start to goal, free at every step; empty if none was found.
std::vector<Coordinates> search(const Coordinates& start, const Coordinates& goal, FreeSpace& free,
                                const SearchSpace& space, const PathSearchOptions& options,
                                std::uint64_t seed);

}  // namespace palpate::planning
