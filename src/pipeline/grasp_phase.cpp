// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/grasp_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "palpate/pipeline/feel_phase.hpp"
#include "palpate/pipeline/grasp_aim.hpp"

namespace palpate::pipeline {
namespace {

constexpr double kSideDistance = 0.22;   // m before the object where a side approach starts
constexpr double kSideOvershoot = 0.03;  // m past the object's place where it ends at the latest
constexpr double kTopDistance = 0.13;    // m above the object where an approach from above starts
constexpr double kTopClearance = 0.003;  // m above the table where it ends at the latest
constexpr double kClear = 0.06;          // m up from where the fingers landed on top
constexpr double kSafeHeight = 0.34;     // m of the base while it travels
constexpr double kTipContact = 0.15;     // N at which a finger counts as touching
constexpr double kLongestClose = 2.5;    // s
constexpr int kStillTicks = 12;
constexpr double kStillStep = 0.0006;  // rad a tick

hand::ActuatorVector open_posture(const GraspRecipe& recipe) {
  hand::ActuatorVector posture = hand::ActuatorVector::Zero();
  const auto set = [&](std::string_view name, double value) {
    posture[hand::actuator_index(name)] = value;
  };
  for (const std::string finger : {"FF", "MF", "RF", "LF"}) {
    set(finger + "J3", recipe.proximal);
    set(finger + "J0", recipe.distal);
  }
  set("FFJ4", -recipe.spread);
  set("LFJ4", -recipe.spread);
  set("LFJ5", recipe.little_base);
  set("THJ5", recipe.thumb_base);
  set("THJ4", recipe.thumb_opposition);
  set("THJ2", recipe.thumb_middle);
  return posture;
}

/// Position of the base that puts it at `ahead`, `left` of a place, seen along the yaw.
hand::BasePosition base_at(const PickState& state, const GraspRecipe& recipe, double ahead,
                           double left, double height) {
  const Eigen::Rotation2Dd turn(state.yaw);
  const Eigen::Vector2d xy = state.place + turn * Eigen::Vector2d(ahead, left);
  return {{xy.x(), xy.y(), height}, {state.yaw, recipe.pitch, recipe.roll}};
}

/// Which fingers are done: they touch, or their command, which never leads the joint by more than
/// the torque limit allows, has stood still for a while.
class FingersDone {
 public:
  void update(const hand::HandReading& reading, const hand::HandCommand& command) {
    for (std::size_t finger = 0; finger < hand::kFingers; ++finger) {
      const double position = command.positions[hand::actuator_index(kDrives[finger])];
      const bool still = std::abs(position - last_[finger]) < kStillStep;
      still_[finger] = still ? still_[finger] + 1 : 0;
      last_[finger] = position;
      if (tip_force(reading, static_cast<int>(finger)) > kTipContact ||
          still_[finger] > kStillTicks) {
        done_[finger] = true;
      }
    }
  }
  bool all() const {
    return std::all_of(done_.begin(), done_.end(), [](bool done) { return done; });
  }
  std::array<bool, hand::kFingers> still_closing() const {
    std::array<bool, hand::kFingers> open{};
    std::transform(done_.begin(), done_.end(), open.begin(), [](bool done) { return !done; });
    return open;
  }

 private:
  std::array<bool, hand::kFingers> done_{};
  static constexpr std::array<std::string_view, hand::kFingers> kDrives = {"THJ5", "FFJ3", "MFJ3",
                                                                           "RFJ3", "LFJ3"};
  std::array<int, hand::kFingers> still_{};
  std::array<double, hand::kFingers> last_{};
};

constexpr std::array<bool, hand::kFingers> kAllFingers = {true, true, true, true, true};

}  // namespace

PhaseEnd GraspPhase::run(Robot& robot, PickState& state) {
  const bool from_side = state.height >= options_.side_from;
  if (state.resting) aim(state, from_side);
  if (from_side) {
    approach_from_side(robot, state);
  } else {
    approach_from_above(robot, state);
  }
  close(robot, from_side ? options_.side : options_.top);
  const int contacts = count_contacts(robot.reading());
  return {contacts >= options_.least_contacts,
          fmt::format("{} grasp, {} contacts", from_side ? "side" : "top", contacts)};
}

void GraspPhase::aim(PickState& state, bool from_side) const {
  const Eigen::Isometry3d& T_world_object = state.resting->modes.front().T_frame_object;
  state.place = T_world_object.translation().head<2>();
  if (from_side) return;
  const GraspAim aim = aim_from_above(mesh_, T_world_object, options_.closing_angle);
  state.place = aim.place;
  state.yaw = aim.yaw;
}

void GraspPhase::travel_to(Robot& robot, const hand::BasePosition& start,
                           const GraspRecipe& recipe) const {
  hand::BasePosition up = robot.command().base;
  up.xyz.z() = std::max(up.xyz.z(), kSafeHeight);
  robot.move_base(up, options_.travel_speed);
  robot.move_fingers(open_posture(recipe), 0.4);
  hand::BasePosition above = start;
  above.xyz.z() = std::max(start.xyz.z(), kSafeHeight);
  robot.move_base(above, options_.travel_speed);
  robot.move_base(start, options_.travel_speed);
  robot.wait(0.2);
}

void GraspPhase::approach_from_side(Robot& robot, const PickState& state) const {
  const GraspRecipe& recipe = options_.side;
  travel_to(robot, base_at(state, recipe, recipe.offset_x, -kSideDistance, recipe.height), recipe);
  const Eigen::Vector3d forward(-std::sin(state.yaw), std::cos(state.yaw), 0);
  robot.move_base(base_at(state, recipe, recipe.offset_x, kSideOvershoot, recipe.height),
                  recipe.approach_speed, lasting_load(robot, forward, recipe.contact_load));
  hand::BasePosition further = robot.command().base;
  further.xyz += recipe.push * forward;
  robot.move_base(further, 0.5 * recipe.approach_speed);
  robot.wait(0.1);
}

void GraspPhase::approach_from_above(Robot& robot, PickState& state) const {
  const GraspRecipe& recipe = options_.top;
  travel_to(robot,
            base_at(state, recipe, recipe.offset_x, recipe.offset_y, state.height + kTopDistance),
            recipe);
  for (int turn = 0; turn < options_.turns; ++turn) {
    descend(robot, state);
    const bool beside =
        lowest_of_hand(robot.model(), robot.reading()) < state.height - options_.least_depth;
    if (beside || turn + 1 == options_.turns) break;
    state.yaw += std::numbers::pi / options_.turns;
    hand::BasePosition raised = robot.command().base;
    raised.xyz.z() += kClear;
    robot.move_base(raised, options_.travel_speed);
    robot.move_base(base_at(state, recipe, recipe.offset_x, recipe.offset_y, raised.xyz.z()),
                    options_.travel_speed);
    robot.wait(0.2);
  }
}

void GraspPhase::descend(Robot& robot, const PickState& state) const {
  const GraspRecipe& recipe = options_.top;
  const hand::BasePosition low = base_at(state, recipe, recipe.offset_x, recipe.offset_y, 0.02);
  const auto loaded = lasting_load(robot, -Eigen::Vector3d::UnitZ(), recipe.contact_load);
  robot.move_base(low, recipe.approach_speed, [&](const hand::HandReading& reading) {
    return loaded(reading) || lowest_of_hand(robot.model(), reading) < kTopClearance;
  });
  robot.wait(0.15);
}

void GraspPhase::close(Robot& robot, const GraspRecipe& recipe) const {
  const hand::ClosingLaw law(robot.actuators(), recipe.closing_rate, recipe.thumb_limit);
  FingersDone done;
  const double end = robot.time() + kLongestClose;
  while (robot.time() < end && !done.all()) {
    robot.set_grip(
        Grip{law, recipe.contact_torque, recipe.wait_for_all ? done.still_closing() : kAllFingers});
    if (robot.wait(hand::kTick) == MotionEnd::timed_out) return;
    done.update(robot.reading(), robot.command());
  }
  robot.mark(Mark::closed);
  const hand::ClosingLaw firm(robot.actuators(), 4.0, recipe.thumb_limit);
  const double start = robot.time();
  while (robot.time() < start + options_.ramp_seconds) {
    const double share = (robot.time() - start + hand::kTick) / options_.ramp_seconds;
    robot.set_grip(
        Grip{firm, hand::blend(recipe.contact_torque, recipe.hold_torque, share), kAllFingers});
    if (robot.wait(hand::kTick) == MotionEnd::timed_out) return;
  }
  robot.set_grip(Grip{firm, recipe.hold_torque, kAllFingers});
  robot.wait(0.1);
}

}  // namespace palpate::pipeline
