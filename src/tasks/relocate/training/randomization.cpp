// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/training/randomization.hpp"

#include "palpate/core/random.hpp"

namespace palpate::relocate {

std::vector<RelocateModel> randomized_worlds(const TaskOptions& task,
                                             const RandomizationOptions& options) {
  std::vector<RelocateModel> worlds = {make_model(task)};
  const auto add = [&](bool changed, auto&& change) {
    if (!changed) return;
    TaskOptions world = task;
    change(world);
    worlds.push_back(make_model(world));
  };
  add(options.friction_scale != 1,
      [&](TaskOptions& world) { world.friction_scale *= options.friction_scale; });
  add(options.mass_scale != 1, [&](TaskOptions& world) { world.mass_scale *= options.mass_scale; });
  add(options.size != 1, [&](TaskOptions& world) { world.size *= options.size; });
  add(options.box, [](TaskOptions& world) { world.object = "box"; });
  return worlds;
}

std::size_t world_of_episode(std::size_t worlds, std::uint64_t seed, std::size_t index) {
  return worlds == 1 ? 0 : RandomStream(seed, "world").fork("episode", index).index(worlds);
}

}  // namespace palpate::relocate
