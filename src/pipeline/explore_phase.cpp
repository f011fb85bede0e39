// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/explore_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::pipeline {
namespace {

constexpr double kPitch = 1.35;        // rad of the base: the first finger points down
constexpr double kAbove = 0.03;        // m over the object's top while travelling
constexpr double kLeastDepth = 0.014;  // m of the fingertip's centre over the table
constexpr double kRest = 0.12;         // s of contact that are averaged
constexpr double kBlockedLoad = 0.4;   // N on the base: something but the fingertip touches
constexpr double kBackOff = 0.03;      // m
constexpr auto kProbe = static_cast<std::size_t>(hand::Finger::first);

/// The first finger straight, the others curled away.
hand::ActuatorVector pointing_hand() {
  hand::ActuatorVector posture = hand::ActuatorVector::Zero();
  for (const std::string finger : {"MF", "RF", "LF"}) {
    posture[hand::actuator_index(finger + "J3")] = 1.4;
    posture[hand::actuator_index(finger + "J0")] = 2.6;
  }
  posture[hand::actuator_index("THJ5")] = -1.0;
  posture[hand::actuator_index("THJ2")] = -0.6;
  return posture;
}

/// Centre of the probing fingertip in the base's frame, by the commanded posture.
Eigen::Vector3d probe_in_base(const Robot& robot) {
  hand::JointVector joints = robot.reading().joints;
  const auto T_base_link = hand::forward_kinematics(robot.model(), joints);
  const auto link = static_cast<std::size_t>(robot.model().distal[kProbe]);
  return T_base_link[link] * robot.model().tips[kProbe].b;
}

/// Base position that brings the probing fingertip to p (world).
hand::BasePosition base_for_probe(const Robot& robot, const Eigen::Vector3d& p) {
  hand::BasePosition base;
  base.ypr = {0, kPitch, 0};
  base.xyz = p - base.pose().linear() * probe_in_base(robot);
  return base;
}

Robot::StopCondition tip_touches(double force) {
  return [force, pressed = 0](const hand::HandReading& reading) mutable {
    pressed = tip_force(reading, static_cast<int>(kProbe)) > force ? pressed + 1 : 0;
    return pressed >= 2;
  };
}

}  // namespace

PhaseEnd ExplorePhase::run(Robot& robot, PickState& state) {
  hand::BasePosition up = robot.command().base;
  up.xyz.z() = std::max(up.xyz.z(), state.height + 0.2);
  robot.move_base(up, options_.travel_speed);
  robot.move_fingers(pointing_hand(), 0.5);
  robot.wait(0.1);
  int touches = 0;
  for (int i = 0; i < options_.touches; ++i) {
    const double angle = 2 * std::numbers::pi * i / options_.touches;
    touches += sweep(robot, state, angle);
  }
  state.resting = locate_resting(object_, robot.model(), robot.log(), locate_, seed_);
  if (state.resting->modes.empty()) {
    state.resting.reset();
    return {false, fmt::format("{} touches that no pose explains", touches)};
  }
  return {true, fmt::format("{} touches, {} ({:.2f})", touches,
                            localization::to_string(state.resting->status),
                            state.resting->modes[0].weight)};
}

bool ExplorePhase::sweep(Robot& robot, const PickState& state, double angle) const {
  const Eigen::Vector2d out(std::cos(angle), std::sin(angle));
  const double depth = std::max(kLeastDepth, state.height - options_.reach);
  const auto at = [&](double radius, double height) {
    const Eigen::Vector2d xy = state.place + radius * out;
    return base_for_probe(robot, {xy.x(), xy.y(), height});
  };
  const hand::BasePosition start = at(options_.radius, depth);
  const hand::BasePosition end = at(-options_.past, depth);
  hand::BasePosition above = start;
  above.xyz.z() += state.height - depth + kAbove;
  robot.move_base(above, options_.travel_speed);
  robot.move_base(start, options_.travel_speed / 2);
  robot.wait(0.15);
  robot.mark(Mark::sweep);
  const auto tip = tip_touches(options_.touch_force);
  const auto blocked = lasting_load(robot, Eigen::Vector3d(-out.x(), -out.y(), 0), kBlockedLoad);
  bool touched = false;
  robot.move_base(end, options_.speed, [&](const hand::HandReading& reading) {
    touched = tip(reading);
    return touched || blocked(reading);
  });
  if (touched) robot.wait(kRest);
  robot.mark(touched ? Mark::touched : Mark::missed);
  hand::BasePosition back = robot.command().base;
  back.xyz.head<2>() += kBackOff * out;
  robot.move_base(back, options_.travel_speed / 4);
  back.xyz.z() = above.xyz.z();
  robot.move_base(back, options_.travel_speed);
  return touched;
}

}  // namespace palpate::pipeline
