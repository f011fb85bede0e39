// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <string>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/grasping/closing_law.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/world/world.hpp"

namespace {

using namespace palpate;

void set(hand::HandCommand& command, const std::string& actuator, double value) {
  command.positions[hand::shadow_hand().actuator(actuator)] = value;
}

/// The open hand over the lying duck, low enough to grasp it.
hand::HandCommand above() {
  hand::HandCommand command;
  command.positions.setZero(hand::kShadowActuators);
  command.mount.xyz << -0.027, -0.020, 0.05;
  command.mount.ypr << 0, 0.475, -0.30;
  set(command, "THJ5", -0.2);
  set(command, "THJ4", 1.03);
  set(command, "THJ2", -0.21);
  for (const std::string finger : {"FF", "MF", "RF", "LF"}) {
    set(command, finger + "J3", 0.094);
    set(command, finger + "J0", 0.54);
  }
  return command;
}

/// The hand closed gently on the duck: how many steps of the simulation a second. Argument: 1 for
/// tips that meet the true surface, 0 for its convex parts.
void step_in_grasp(benchmark::State& state) {
  simulation::WorldOptions options;
  options.exact_tips = state.range(0) != 0;
  simulation::World world(geometry::load_known_object("duck"), options, 1);
  const hand::Preshape& preshape = world.hand_model().postures.top;
  const grasping::ClosingLaw closing(world.hand_model(), 3.0, preshape.closed);
  hand::HandCommand command = above();
  world.reset({.stable_pose = 0, .yaw = 3.0}, command);
  hand::HandReading reading = world.hand().step(command);
  const auto tick = [&] {
    closing.advance(command, reading, preshape.contact_torque, {true, true, true, true, true});
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
BENCHMARK(step_in_grasp)->ArgName("exact")->Arg(1)->Arg(0)->Unit(benchmark::kMicrosecond);

}  // namespace
