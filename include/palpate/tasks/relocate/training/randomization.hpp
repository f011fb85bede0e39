// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/tasks/relocate/rollout.hpp"

namespace palpate::relocate {

/// How the worlds that a search draws its episodes from differ from the task (Tobin et al. 2017,
/// with one change at a time). What is 1, or not set, is not changed.
struct RandomizationOptions {
  double friction_scale = 1;
  double mass_scale = 1;
  double size = 1;
  bool box = false;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("friction_scale", friction_scale, 0.01, 100.0,
      "factor on all sliding friction in one of the worlds");
    v("mass_scale", mass_scale, 0.01, 100.0,
      "factor on the object's mass and inertia in one of the worlds");
    v("size", size, 0.5, 2.0, "factor on the object's size in one of the worlds");
    v("box", box, "use a box as the object in one of the worlds");
  }
};

/// The task, and a world for each change.
/// @throws BadInput as make_model does
std::vector<RelocateModel> randomized_worlds(const TaskOptions& task,
                                             const RandomizationOptions& options);

/// Which of `worlds` worlds episode `index` of a seed takes place in; the same for all candidates.
std::size_t world_of_episode(std::size_t worlds, std::uint64_t seed, std::size_t index);

}  // namespace palpate::relocate
