// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <string>

#include "palpate/geometry/capsule_collider.hpp"
#include "palpate/geometry/known_object.hpp"
#include "palpate/hand/closing.hpp"
#include "palpate/simulation/world.hpp"

namespace {

using namespace palpate;

void set(hand::HandCommand& command, const std::string& actuator, double value) {
  command.positions[hand::actuator_index(actuator)] = value;
}

/// The open hand over the lying bunny, low enough to grasp it.
hand::HandCommand above() {
  hand::HandCommand command;
  command.base.xyz << -0.027, -0.020, 0.05;
  command.base.ypr << 0, 0.475, -0.30;
  set(command, "THJ5", -0.2);
  set(command, "THJ4", 1.03);
  set(command, "THJ2", -0.21);
  for (const std::string finger : {"FF", "MF", "RF", "LF"}) {
    set(command, finger + "J3", 0.094);
    set(command, finger + "J0", 0.54);
  }
  return command;
}

/// The hand closed gently on the bunny: how many steps of the simulation a second.
void step_in_grasp(benchmark::State& state) {
  const simulation::WorldOptions options;
  simulation::World world(geometry::load_known_object("bunny"), options, 1);
  const hand::ClosingLaw closing(world.hand().actuators(), 3.0, 0.718);
  hand::HandCommand command = above();
  world.reset({.stance = 0, .yaw = 3.0}, command);
  hand::HandReading reading;
  const auto tick = [&] {
    closing.advance(command, reading, {}, {true, true, true, true, true});
    reading = world.hand().step(command);
  };
  for (int i = 0; i < 300; ++i) tick();
  double contacts = 0;
  for (auto _ : state) {
    tick();
    for (const auto& finger : reading.contacts) contacts += static_cast<double>(finger.size());
  }
  const auto ticks = static_cast<double>(state.iterations());
  state.counters["steps/s"] =
      benchmark::Counter(ticks * hand::kTick / options.time_step, benchmark::Counter::kIsRate);
  state.counters["contacts"] = contacts / ticks;
}
BENCHMARK(step_in_grasp)->Unit(benchmark::kMicrosecond);

/// One fingertip against the true surface of the bunny.
void meet_fingertip(benchmark::State& state) {
  const geometry::MeshQuery mesh(geometry::load_known_object("bunny").mesh);
  const geometry::CapsuleCollider collider(mesh);
  RandomStream random(1);
  std::vector<geometry::Capsule> capsules;
  for (int i = 0; i < 256; ++i) {
    const geometry::ClosestPoint near = mesh.closest_point(0.1 * random.unit_vector());
    const Eigen::Vector3d middle = near.point + 0.0068 * near.normal;
    const Eigen::Vector3d half = 0.009 * near.normal.cross(random.unit_vector()).normalized();
    capsules.push_back({middle - half, middle + half, 0.007});
  }
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(collider.contacts(capsules[i++ % capsules.size()], 0, 2));
  }
}
BENCHMARK(meet_fingertip)->Unit(benchmark::kMicrosecond);

}  // namespace
