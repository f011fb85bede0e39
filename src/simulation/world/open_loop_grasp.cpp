// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/world/open_loop_grasp.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "palpate/hand/shadow.hpp"

namespace palpate::simulation {
namespace {

constexpr double kApproach = 0.22;   // m before the object where a side approach starts
constexpr double kOvershoot = 0.03;  // m past its place where it ends at the latest
constexpr double kSpeed = 0.1;       // m/s
constexpr double kDescent = 0.08;    // m, from where the approach from above starts
constexpr double kSideLoad = 1.0;    // N on the mount that ends the approach
constexpr double kTopLoad = 2.5;     // N
constexpr int kSettingOut = 40;      // ticks whose load is that of setting out
constexpr double kLift = 0.1;        // m
constexpr double kRamp = 0.8;        // s, to the holding torques
constexpr double kHangs = 0.05;      // m above the table

constexpr hand::PerFinger<bool> kAll = {true, true, true, true, true};

/// Largest torques of the closing, N m, by the joint that an actuator drives.
struct Torques {
  double knuckle, middle, thumb, thumb_tip;
};
constexpr Torques kTouch = {.knuckle = 0.098, .middle = 0.07, .thumb = 0.098, .thumb_tip = 0.07};
constexpr Torques kHold = {.knuckle = 0.23, .middle = 0.2, .thumb = 0.2, .thumb_tip = 0.14};

hand::ActuatorVector by_actuator(const hand::Description& hand, const Torques& torques) {
  hand::ActuatorVector result = hand::ActuatorVector::Zero(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const hand::Actuator& actuator = hand.actuators[static_cast<std::size_t>(i)];
    const bool thumb = actuator.finger == hand.thumb, tip = actuator.name == "THJ1";
    result[i] = thumb               ? (tip ? torques.thumb_tip : torques.thumb)
                : actuator.coupling ? torques.middle
                                    : torques.knuckle;
  }
  return result;
}

int ticks(double seconds) { return static_cast<int>(std::lround(seconds / hand::kTick)); }

hand::HandCommand opened(const hand::Description& hand, const OpenLoopGrasp& grasp) {
  hand::HandCommand command;
  command.positions.setZero(hand.actuator_count());
  const auto set = [&](const std::string& name, double value) {
    command.positions[hand.actuator(name)] = value;
  };
  for (const std::string finger : {"FF", "MF", "RF", "LF"}) {
    set(finger + "J3", grasp.side ? 0.175 : 0.094);
    set(finger + "J0", grasp.side ? 0.328 : 0.54);
  }
  set("FFJ4", grasp.side ? -0.18 : -0.087);
  set("LFJ4", grasp.side ? -0.18 : -0.087);
  set("LFJ5", 0.1);
  set("THJ5", grasp.side ? -0.3 : -0.2);
  set("THJ4", grasp.side ? 1.08 : 1.03);
  set("THJ2", grasp.side ? -0.34 : -0.21);
  if (grasp.side) {
    command.mount.xyz << 0.002, -kApproach, grasp.height;
    command.mount.ypr << 0, 0.197, 0.5 * std::numbers::pi - 0.017;
  } else {
    command.mount.xyz << -0.027, -0.02, grasp.height + kDescent;
    command.mount.ypr << 0, 0.475, -0.3;
  }
  return command;
}

/// Moves the mount along y, or down, until it bears a load or the way is done.
hand::HandReading approach(World& world, hand::HandCommand& command, bool side) {
  hand::HandReading reading;
  const int axis = side ? 1 : 2;
  const double way = side ? kApproach + kOvershoot : -kDescent;
  const double load = side ? kSideLoad : kTopLoad;
  const int most = ticks(std::abs(way) / kSpeed);
  for (int tick = 0; tick < most; ++tick) {
    command.mount.xyz[axis] += way / most;
    reading = world.hand().step(command);
    if (tick > kSettingOut && std::abs(reading.mount_force[axis]) > load) break;
  }
  return reading;
}

}  // namespace

bool run_open_loop_grasp(World& world, const OpenLoopGrasp& grasp, hand::HandCommand* last) {
  const hand::Description& hand = world.hand_model();
  hand::HandCommand command = opened(hand, grasp);
  world.reset(grasp.start, command);
  hand::HandReading reading = approach(world, command, grasp.side);
  hand::ActuatorVector closed_end = hand.postures.side.closed;
  closed_end[hand.actuator("THJ5")] = grasp.side ? 0.785 : 0.718;
  const grasping::ClosingLaw law(hand, grasp.side ? 1.76 : 3.0, closed_end);
  const hand::ActuatorVector touch = by_actuator(hand, kTouch);
  const hand::ActuatorVector hold = grasp.grip * by_actuator(hand, kHold);
  const int closed = ticks(grasp.close_seconds), held = closed + ticks(kRamp);
  const int lifted = held + ticks(grasp.lift_seconds);
  for (int tick = 0; tick < lifted + ticks(grasp.hold_seconds); ++tick) {
    const double share = std::clamp((tick - closed) * hand::kTick / kRamp, 0.0, 1.0);
    law.advance(command, reading, touch + share * (hold - touch), kAll);
    if (tick >= held && tick < lifted) command.mount.xyz.z() += kLift / (lifted - held);
    reading = world.hand().step(command);
  }
  if (last) *last = command;
  return !world.diverged() && world.truth().lowest_point > kHangs;
}

}  // namespace palpate::simulation
