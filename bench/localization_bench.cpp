// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "localization/scenes.hpp"

namespace {

using namespace palpate;
using namespace palpate::localization;

/// Balls beside the object, as a hand's.
std::vector<FreeSphere> balls_beside(const geometry::ObjectModel& model, const Eigen::Isometry3d& T,
                                     std::size_t count) {
  constexpr double kRadius = 0.009;
  RandomStream random(2);
  std::vector<FreeSphere> balls;
  while (balls.size() < count) {
    const Eigen::Vector3d center = 0.08 * random.normal3();
    const double distance = mesh_of(model).signed_distance(center);
    if (distance > kRadius + 0.001 && distance < 0.05) balls.push_back({T * center, kRadius});
  }
  return balls;
}

/// Arguments: contacts, balls of free space, 1 with a table.
void localize_object(benchmark::State& state) {
  const geometry::ObjectModel& model = model_of("duck");
  SceneOptions options;
  options.contacts = static_cast<int>(state.range(0));
  options.table = state.range(2) == 1;
  Scene scene = make_scene(model, options, RandomStream(1));
  scene.evidence.free_space =
      balls_beside(model, scene.truth, static_cast<std::size_t>(state.range(1)));
  for (auto _ : state) benchmark::DoNotOptimize(localize(model, scene.evidence, RandomStream(1)));
}

BENCHMARK(localize_object)
    ->ArgNames({"contacts", "balls", "table"})
    ->Args({4, 80, 1})
    ->Args({10, 0, 0})
    ->Args({10, 80, 0})
    ->Args({10, 800, 0})
    ->Args({20, 80, 0})
    ->Unit(benchmark::kMillisecond);

}  // namespace
