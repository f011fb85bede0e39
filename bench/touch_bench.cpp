// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "normal_clusters.hpp"
#include "palpate/tactile/normals/normal_estimator.hpp"
#include "tactile/sliding.hpp"

namespace {

using namespace palpate;
using namespace palpate::tactile;

std::vector<FingerSample> samples_over_an_edge() {
  const SlidingOptions options;
  const RandomStream random(1);
  return samples_along(sliding_path(Surface::edge, options, random), options, random);
}

/// Time of one sample through an estimator, by its place in normal_estimators().
void estimate_normal(benchmark::State& state) {
  const std::string& name = normal_estimators().at(static_cast<std::size_t>(state.range(0)));
  state.SetLabel(name);
  auto samples = samples_over_an_edge();
  const auto estimator = make_normal_estimator(name);
  const double period = samples[1].time - samples[0].time;
  double time = 0;
  std::size_t next = 0;
  for (auto _ : state) {
    FingerSample& sample = samples[next++ % samples.size()];
    sample.time = time += period;
    benchmark::DoNotOptimize(estimator->update(sample));
  }
}
BENCHMARK(estimate_normal)->ArgName("estimator")->DenseRange(0, 5);

/// Ten ticks of two contacts each.
void cluster_ten_ticks(benchmark::State& state) {
  RandomStream random(2);
  std::vector<NormalAt> contacts;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d n = i % 2 == 0 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
    contacts.push_back({0.001 * random.normal3(), (n + 0.1 * random.normal3()).normalized()});
  }
  for (auto _ : state) benchmark::DoNotOptimize(cluster_normals(contacts));
}
BENCHMARK(cluster_ten_ticks);

}  // namespace
