// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "palpate/tasks/relocate/relocate_dynamics.hpp"
#include "palpate/tasks/relocate/relocate_touch.hpp"
#include "tasks/relocate/task_arm.hpp"

namespace palpate::relocate {

/// The hand of an episode as skills move it: what they command becomes actions of the task, and
/// its fingertips sense what is in the task's own world. All joints are held by springs whose
/// weight is compensated; the arm's are stiffer than the task's servos, which the actions make up
/// for.
class TaskHand : public hand::Hand {
 public:
  /// @param task  in which it is; must outlive the hand, as `touch` must
  TaskHand(RelocateTask& task, const RelocateModel& model, const RelocateTouch& touch);

  [[nodiscard]] const hand::Description& description() const { return touch_.hand_model(); }

  /// Where it stands now, as a command.
  [[nodiscard]] hand::HandCommand here() const;

  std::optional<hand::HandReading> sense() override;
  /// @throws std::runtime_error where the physics has become unstable
  hand::HandReading step(const hand::HandCommand& command) override;
  [[nodiscard]] hand::PathFeasibility check_path(
      std::span<const hand::MountPosition> path) const override;
  [[nodiscard]] hand::MountLimits mount_limits() const override;

  [[nodiscard]] int steps() const { return steps_; }  ///< that it has made of the task

 private:
  [[nodiscard]] RelocateJoints joints_of(const hand::HandCommand& command) const;

  RelocateTask& task_;
  const RelocateTouch& touch_;
  TaskArm arm_;
  RelocateDynamics dynamics_;
  RelocateJoints target_;                           // of the last command
  Eigen::Vector3d load_ = Eigen::Vector3d::Zero();  // on the mount, low-pass filtered, N
  int steps_ = 0;
};

}  // namespace palpate::relocate
