// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/query/capsule_collider.hpp"
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

/// The same surface of four times as many triangles.
geometry::TriangleMesh subdivided(const geometry::TriangleMesh& mesh) {
  geometry::TriangleMesh result{mesh.vertices, {}};
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [found, added] =
        middles.try_emplace(std::minmax(a, b), static_cast<int>(result.vertices.size()));
    if (added) {
      result.vertices.push_back(0.5 * (mesh.vertices[static_cast<std::size_t>(a)] +
                                       mesh.vertices[static_cast<std::size_t>(b)]));
    }
    return found->second;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const auto& t : {std::array{a, ab, ca}, std::array{b, bc, ab}, std::array{c, ca, bc},
                          std::array{ab, bc, ca}}) {
      result.triangles.push_back(t);
    }
  }
  return result;
}

/// One fingertip against the true surface of the duck. Argument: how often each triangle is cut in
/// four.
void meet_fingertip(benchmark::State& state) {
  geometry::TriangleMesh surface = geometry::load_known_object("duck").mesh;
  for (int i = 0; i < state.range(0); ++i) surface = subdivided(surface);
  const geometry::MeshQuery mesh(std::move(surface));
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
  state.counters["triangles"] = static_cast<double>(mesh.mesh().triangles.size());
}
BENCHMARK(meet_fingertip)->ArgName("cuts")->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMicrosecond);

}  // namespace
