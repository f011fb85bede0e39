// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/simulation/rendering/renderer.hpp"
#include "palpate/tasks/relocate/relocate_dynamics.hpp"
#include "palpate/tasks/relocate/rollout.hpp"

namespace palpate::relocate {

/// What the relocate task looks like: the hand as the Shadow hand that the Adroit hand models, the
/// object's parts, and where they are at the simulator's positions.
class DrawnTask {
 public:
  /// @throws BadInput if the object or the drawn hand cannot be used
  DrawnTask(const TaskOptions& task, const RelocateModel& model);

  [[nodiscard]] const hand::Description& hand() const { return hand_; }
  [[nodiscard]] const geometry::KnownObject& object() const { return object_; }

  /// @param positions  as RelocateTask::positions gives them
  [[nodiscard]] simulation::DrawnState at(const Eigen::VectorXd& positions);

  /// The same, with the object see-through at its target, upright as it is.
  /// @param target  m
  [[nodiscard]] simulation::DrawnState at(const Eigen::VectorXd& positions,
                                          const Eigen::Vector3d& target);

 private:
  RelocateDynamics dynamics_;
  hand::Description hand_;
  geometry::KnownObject object_;
};

/// Shows table, target and all of the hand, wherever an episode takes them.
simulation::Camera task_camera();

}  // namespace palpate::relocate
