// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <memory>

#include "palpate/tactile/biotac/inverse.hpp"

namespace palpate::tactile {
namespace {

/// All channels of five tips, each pressed on a ball; items are frames of the whole hand.
void five_biotacs(benchmark::State& state) {
  const BiotacSkin skin;
  std::vector<BiotacSensor> sensors;
  for (int tip = 0; tip < 5; ++tip) {
    sensors.emplace_back(skin, BiotacSensorOptions{},
                         RandomStream(static_cast<std::uint64_t>(tip)));
  }
  const hand::TipContact contact{.p = {0, 0, -0.007}, .n = {0, 0, 1}, .f = {0.3, 0.2, -2}};
  const Eigen::Vector3d center(0, 0, -0.037);
  for (auto _ : state) {
    for (auto& sensor : sensors) {
      const auto pressed = skin.press(
          {&contact, 1}, [&](const Eigen::Vector3d& x) { return (x - center).norm() - 0.03; });
      benchmark::DoNotOptimize(sensor.step(pressed));
    }
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(five_biotacs);

void infer_a_contact(benchmark::State& state) {
  BiotacDatasetOptions options;
  options.trajectories = 30;
  options.seconds = 1;
  const auto frames = simulate_biotac(options);
  BiotacInverseOptions training;
  training.epochs = 5;
  const auto model = BiotacInverse::train(frames, training);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(model.estimate(frames[i++ % frames.size()].decoded));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(infer_a_contact);

}  // namespace
}  // namespace palpate::tactile
