// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/grasping/finger_motion.hpp"
#include "palpate/skills/forward_model.hpp"
#include "palpate/skills/reorient/in_hand_reorientation.hpp"

namespace palpate::skills {

/// The grasp as it is seen before a step.
struct GraspView {
  hand::HandCommand command;
  hand::JointVector joints;                ///< averaged over the look
  std::vector<tactile::Contact> contacts;  ///< mount's frame
  std::vector<tactile::Contact> lost;      ///< where fingertips that touch no more touched last
  double regain = 0;                       ///< m by which these press into the object
  Eigen::Isometry3d T_mount_object = Eigen::Isometry3d::Identity();  ///< tracked
  hand::ActuatorVector lead;  ///< rad, that corrects the forces
};

/// Position targets that the motion asks of the fingers, within what the actuators can.
hand::ActuatorVector targets_of(const Executor& robot, const GraspView& view,
                                const grasping::GraspMotion& motion);

/// [w; v] that takes one pose to another: R' = exp(w) R, t' = t + v.
Vector6d way_between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to);

/// A motion, and what a rollout of it says that the object does.
struct ChosenStep {
  grasping::GraspMotion motion;
  std::optional<Eigen::Isometry3d> displacement;  ///< T_after_before, mount's frame
  bool falls = false;                             ///< in the rollout the object is lost
};

/// Tries motions in rollouts and mixes those that end well.
class StepSampler {
 public:
  StepSampler(const geometry::KnownObject& object, const Executor& robot,
              const ReorientOptions& options, int threads);

  /// The motion of the next `period` that should bring the object along `step`.
  ChosenStep choose(const GraspView& view, const Vector6d& step, RandomStream random);

  [[nodiscard]] int rollouts() const { return rollouts_; }

 private:
  std::vector<grasping::GraspMotion> variants(const Vector6d& step, RandomStream& random) const;
  std::vector<hand::HandCommand> commands_of(const GraspView& view,
                                             const grasping::GraspMotion& motion) const;
  double cost(const RolloutOutcome& settled, const RolloutOutcome& end, const Vector6d& step) const;
  grasping::GraspMotion mix(const std::vector<grasping::GraspMotion>& motions,
                            const std::vector<double>& costs) const;

  const Executor& robot_;
  const ReorientOptions& options_;
  std::vector<std::unique_ptr<ForwardModel>> models_;  // one a thread
  int rollouts_ = 0;
};

}  // namespace palpate::skills
