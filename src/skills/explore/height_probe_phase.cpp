// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/explore/height_probe_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "palpate/skills/stop_conditions.hpp"
#include "skills/motion/lowest_part.hpp"
#include "skills/motion/motion_constants.hpp"
#include "skills/motion/take_posture.hpp"

namespace palpate::skills {
namespace {

constexpr double kRetreat = 0.06;  // m, up from the touch
constexpr double kSlowAbove =
    0.025;  // m above what may stand there, from where it comes down slowly

constexpr double kYawStep = std::numbers::pi / 6;  // rad between attitudes that are tried

/// Where to probe for the object, as shares of the search's width from its rough place: what a
/// touch has rolled away may be at the corners.
const std::vector<Eigen::Vector2d> kSearch = {{0, 0},  {0.5, 0}, {0, 0.5}, {-0.5, 0}, {0, -0.5},
                                              {1, 0},  {0, 1},   {-1, 0},  {0, -1},   {1, 1},
                                              {-1, 1}, {-1, -1}, {1, -1}};

}  // namespace

PhaseEnd HeightProbePhase::run(Executor& robot, PickState& state) {
  const Eigen::Vector2d rough = state.place;
  const hand::FlatHand& flat = robot.model().postures.flat;
  const double low =
      lowest_on_way(robot.model(), flat.positions, attitude_of(robot.command().mount),
                    flat.positions, flat.attitude);
  hand::MountPosition high = robot.command().mount;
  if (high.xyz.z() < state.clear_height - low) {
    high.xyz.z() = state.clear_height - low;
    robot.move_mount(high, options_.travel_speed);
  }
  take_posture(robot, flat.positions, 0.4);
  for (const auto& side : kSearch) {
    const Eigen::Vector2d place = rough + options_.search * side;
    if (!lower(robot, state, place)) continue;
    state.place = place;
    return {true, fmt::format("{:.0f} mm tall", 1e3 * state.height)};
  }
  return {false, fmt::format("found nothing that rises more than {:.0f} mm above the table",
                             1e3 * options_.clearance)};
}

/// Height of the mount from which it comes down: nothing of the flat hand is over an object then.
double HeightProbePhase::start_height(const hand::Description& hand, double clear_height) const {
  const hand::FlatHand& flat = hand.postures.flat;
  return std::max(options_.start_height,
                  clear_height - lowest_part(hand, flat.positions, flat.attitude));
}

/// Over a place, flat, turned from the state's yaw no farther than the mount's reach requires, here
/// and, if possible, down to the table.
hand::MountPosition HeightProbePhase::reachable(const Executor& robot, const PickState& state,
                                                const Eigen::Vector2d& place) const {
  const hand::FlatHand& flat = robot.model().postures.flat;
  const double low = lowest_part(robot.model(), flat.positions, flat.attitude);
  const auto over = [&](double yaw, double height) {
    const Eigen::Vector2d xy = place - Eigen::Rotation2Dd(yaw) * flat.center;
    hand::MountPosition mount;
    mount.xyz = {xy.x(), xy.y(), height};
    mount.ypr = {yaw, flat.attitude.pitch, flat.attitude.roll};
    return mount;
  };
  const double start = start_height(robot.model(), state.clear_height);
  std::optional<double> reachable_above;
  for (int step = 0; kYawStep * step <= std::numbers::pi; ++step) {
    for (const double turn : {kYawStep * step, -kYawStep * step}) {
      const double yaw = state.yaw + turn;
      if (!robot.obstacle(over(yaw, start)).empty()) continue;
      if (robot.obstacle(over(yaw, options_.clearance - low)).empty()) return over(yaw, start);
      if (!reachable_above) reachable_above = yaw;
    }
  }
  return over(reachable_above.value_or(state.yaw), start);
}

/// Comes down flat over a place. @return whether there was something above the table
bool HeightProbePhase::lower(Executor& robot, PickState& state,
                             const Eigen::Vector2d& place) const {
  const hand::MountPosition above = reachable(robot, state, place);
  robot.move_mount(above, options_.travel_speed);
  tare(robot);

  const bool found = descend(robot);
  if (found) {
    robot.add_event(estimation::TouchEvent::height_probed);
    state.height = estimation::lowest_of_hand(robot.model(), robot.reading());
  }
  hand::MountPosition up = robot.command().mount;
  up.xyz.z() = found ? up.xyz.z() + kRetreat : above.xyz.z();
  robot.move_mount(up, options_.travel_speed);
  return found;
}

/// Down, until something bears the hand or it is close to the table. @return whether it was borne
bool HeightProbePhase::descend(Executor& robot) const {
  bool found = false;
  const auto down_to = [&](double height, double speed) {
    hand::MountPosition low = robot.command().mount;
    low.xyz.z() = height;
    const auto touched = lasting_load(robot, -Eigen::Vector3d::UnitZ(), options_.touch_force);
    return robot.move_mount(low, speed, [&](const hand::HandReading& reading) {
      found = touched(reading);
      return found || estimation::lowest_of_hand(robot.model(), reading) < options_.clearance;
    });
  };
  const double height = robot.command().mount.xyz.z();
  const double lowest = estimation::lowest_of_hand(robot.model(), robot.reading());
  const double clear_way = lowest - std::max(options_.clearance, tallest_ + kSlowAbove);
  if (clear_way > 0 && down_to(height - clear_way, options_.speed) != MotionEnd::reached) {
    return found;
  }
  down_to(-options_.start_height, options_.touch_speed);
  return found;
}

}  // namespace palpate::skills
