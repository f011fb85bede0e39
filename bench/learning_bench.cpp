// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <string>

#include "palpate/core/assets.hpp"
#include "palpate/tasks/relocate/policies/policy_io.hpp"
#include "palpate/tasks/relocate/rollout.hpp"

namespace palpate::relocate {
namespace {

/// Steps of control per second while the shipped policy holds the mug; threads as the argument.
void relocate_rollouts(benchmark::State& state, const std::string& solver) {
  constexpr std::size_t kEpisodes = 8;
  TaskOptions options;
  options.solver = solver;
  const auto model = make_model(options);
  const auto policy = load_policy(asset("models/relocate-best.json"));
  double steps = 0;
  for (auto _ : state) {
    for (const auto& episode :
         rollout(model, *policy, {}, 9000, kEpisodes, static_cast<int>(state.range(0)))) {
      steps += episode.steps;
    }
  }
  state.counters["steps/s"] = benchmark::Counter(steps, benchmark::Counter::kIsRate);
}

BENCHMARK_CAPTURE(relocate_rollouts, faithful, "faithful")->Arg(1)->Arg(2)->UseRealTime();
BENCHMARK_CAPTURE(relocate_rollouts, newton, "newton")->Arg(1)->Arg(2)->UseRealTime();
BENCHMARK_CAPTURE(relocate_rollouts, fast, "fast")->Arg(1)->Arg(2)->UseRealTime();

}  // namespace
}  // namespace palpate::relocate
