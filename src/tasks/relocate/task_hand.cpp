// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/task_hand.hpp"

#include <stdexcept>

#include "palpate/hand/kinematics.hpp"
#include "tasks/relocate/relocate_model.hpp"

namespace palpate::relocate {
namespace {

constexpr int kSlides = 3, kWrist = 2;
constexpr double kSlideStiffness = 2000, kSlideDamping = 180;  // N/m, N s/m beside the passive one
constexpr double kHingeStiffness = 300;                        // N m/rad
constexpr double kArmDamping = 20;      // N s/m, N m s/rad, of the task's arm, passive
constexpr double kWristStiffness = 10;  // N m/rad, of the task's servos
constexpr double kFingerStiffness = 1;  // N m/rad, of the task's servos
constexpr double kLoadFilter = 0.2;     // of a new reading of the mount's load
// The arm's lift bears about 50 N of weight, and exerts 60 N where it is highest.
constexpr hand::MountLimits kLimits = {.acceleration = 1.0, .turn_acceleration = 5.0};

Eigen::DiagonalMatrix<double, kRelocateJoints> stiffness() {
  RelocateJoints result = RelocateJoints::Constant(kFingerStiffness);
  result.head<kSlides>().setConstant(kSlideStiffness);
  result.segment<kArmJoints - kSlides>(kSlides).setConstant(kHingeStiffness);
  result.segment<kWrist>(kArmJoints).setConstant(kWristStiffness);
  return result.asDiagonal();
}

}  // namespace

TaskHand::TaskHand(RelocateTask& task, const RelocateModel& model, const RelocateTouch& touch)
    : task_(task), touch_(touch), arm_(model), dynamics_(model) {
  target_ = task.positions().head<kRelocateJoints>();
}

hand::HandCommand TaskHand::here() const {
  const RelocateJoints q = task_.positions().head<kRelocateJoints>();
  return {hand::actuator_positions(touch_.hand_model(), shadow_joints(q)), arm_.mount(q)};
}

std::optional<hand::HandReading> TaskHand::sense() { return touch_.read(task_, steps_); }

RelocateJoints TaskHand::joints_of(const hand::HandCommand& command) const {
  const hand::Description& hand = touch_.hand_model();
  RelocateJoints q = task_joints(hand::joints_in_free_flexion(hand, command.positions));
  q = q.cwiseMax(dynamics_.lower()).cwiseMin(dynamics_.upper());
  q.head<kArmJoints>() = arm_.joints(command.mount);
  return q;
}

hand::HandReading TaskHand::step(const hand::HandCommand& command) {
  const RelocateJoints next = joints_of(command);
  RelocateJoints speed = RelocateJoints::Zero();
  speed.head<kArmJoints>() = (next - target_).head<kArmJoints>() / hand::kTick;
  target_ = next;
  const RelocateJoints q = task_.positions().head<kRelocateJoints>();
  const RelocateJoints v = RelocateJoints::Map(task_.impl().data->qvel);  // as its servos have it
  const RelocateJoints still = RelocateJoints::Zero();
  RelocateJoints torques = dynamics_.torques(q, still, still) + stiffness() * (next - q);
  torques += kArmDamping * speed;
  torques.head<kSlides>() += kSlideDamping * (speed - v).head<kSlides>();
  if (task_.step(dynamics_.action(q, v, torques)).diverged) {
    throw std::runtime_error("the simulation became unstable");
  }
  ++steps_;
  hand::HandReading reading = touch_.read(task_, steps_);
  load_ += kLoadFilter * (reading.mount_force - load_);
  reading.mount_force = load_;
  return reading;
}

hand::PathFeasibility TaskHand::check_path(std::span<const hand::MountPosition> path) const {
  hand::PathFeasibility result;
  for (const hand::MountPosition& mount : path) {
    result.obstacle = arm_.obstacle(arm_.joints(mount));
    if (!result.obstacle.empty()) return result;
    ++result.feasible;
  }
  return result;
}

hand::MountLimits TaskHand::mount_limits() const { return kLimits; }

}  // namespace palpate::relocate
