// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/start.hpp"

#include <fmt/format.h>

#include <numbers>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"

namespace palpate::evaluation {
namespace {

constexpr int kDraws = 10;

simulation::Start drawn(const geometry::KnownObject& object, const StartOptions& options,
                        RandomStream random) {
  const int count = static_cast<int>(object.stable_poses.size());
  if (options.stable_pose >= count) {
    throw BadInput(fmt::format("start.stable_pose = {}: {} has the stable poses 0..{}",
                               options.stable_pose, object.name, count - 1));
  }
  simulation::Start start;
  double share = random.uniform();
  while (start.stable_pose + 1 < count &&
         share >= object.stable_poses[static_cast<std::size_t>(start.stable_pose)].probability) {
    share -= object.stable_poses[static_cast<std::size_t>(start.stable_pose)].probability;
    ++start.stable_pose;
  }
  if (options.stable_pose >= 0) start.stable_pose = options.stable_pose;
  start.yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double half_width = options.half_width();
  start.xy.x() = options.x + random.uniform(-half_width, half_width);
  start.xy.y() = options.y + random.uniform(-half_width, half_width);
  return start;
}

/// Whether the object comes to rest near its rough place.
bool stays(simulation::World& world, const simulation::Start& start, const StartOptions& options,
           const hand::HandCommand& waiting) {
  const auto place = world.resting_place(start, waiting);
  return place && (*place - Eigen::Vector2d(options.x, options.y)).cwiseAbs().maxCoeff() <=
                      options.half_width() + kPlaceMargin;
}

}  // namespace

hand::HandCommand waiting_command(const hand::Description& hand) {
  hand::HandCommand command;
  command.positions.resize(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    command.positions[i] = hand::straight_command(hand.actuators[static_cast<std::size_t>(i)]);
  }
  command.mount.xyz = {0, 0, 0.34};
  return command;
}

simulation::Start draw_start(const geometry::KnownObject& object, const StartOptions& options,
                             std::uint64_t seed) {
  return drawn(object, options, RandomStream(seed, "start"));
}

simulation::Start start_trial(simulation::World& world, const geometry::KnownObject& object,
                              const StartOptions& options, std::uint64_t seed) {
  const hand::HandCommand waiting = waiting_command(world.hand_model());
  const RandomStream random(seed, "start");
  const simulation::Start first = drawn(object, options, random);
  simulation::Start start = first;
  for (std::uint64_t draw = 1; !stays(world, start, options, waiting); ++draw) {
    if (draw == kDraws) {
      start = first;
      break;
    }
    start = drawn(object, options, random.fork("draw", draw));
  }
  world.reset(start, waiting);
  return start;
}

}  // namespace palpate::evaluation
