// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "palpate/registration/registration.hpp"
#include "registration/problems.hpp"

namespace {

using namespace palpate;
using namespace palpate::registration;

constexpr std::uint64_t kProblems = 20;  // in turn, as their difficulty differs

std::vector<Correspondences> problems(std::size_t pairs, double outliers, double noise) {
  std::vector<Correspondences> result;
  for (std::uint64_t seed = 0; seed < kProblems; ++seed) {
    result.push_back(testing::make_problem({.pairs = pairs, .outliers = outliers, .noise = noise},
                                           RandomStream(seed, "bench"))
                         .correspondences);
  }
  return result;
}

/// Arguments: pairs, outliers in thousandths.
void register_pairs(benchmark::State& state) {
  const auto all = problems(static_cast<std::size_t>(state.range(0)),
                            1e-3 * static_cast<double>(state.range(1)), 0.001);
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(register_correspondences(all[next++ % all.size()]));
  }
}
BENCHMARK(register_pairs)
    ->ArgNames({"pairs", "outliers"})
    ->ArgsProduct({{1000}, {100, 500, 900, 950, 980, 990}})
    ->ArgsProduct({{50, 10000, 100000}, {500, 900}})
    ->Unit(benchmark::kMicrosecond);

/// Arguments: pairs, 1 for planes.
void certified_rotation(benchmark::State& state) {
  const auto primitive = state.range(1) == 1 ? Primitive::kPlane : Primitive::kPoint;
  std::vector<Matrix10d> objectives;
  for (const auto& c : problems(static_cast<std::size_t>(state.range(0)), 0, 0.001)) {
    objectives.push_back(
        marginalize(quadratic_form(c, {}, primitive, weighted_means(c, {}))).objective);
  }
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(solve_rotation(objectives[next++ % objectives.size()]));
  }
}
BENCHMARK(certified_rotation)
    ->ArgNames({"pairs", "planes"})
    ->ArgsProduct({{7, 10, 20, 50, 1000}, {0, 1}})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
