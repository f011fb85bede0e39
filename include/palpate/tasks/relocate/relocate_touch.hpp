// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "palpate/core/random.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/simulation/contact/sensor_noise.hpp"
#include "palpate/tasks/relocate/relocate_task.hpp"

namespace palpate::relocate {

class TaskArm;

/// Joints of the Shadow hand that hold it as the Adroit hand is held at these positions: the latter
/// models the former, with the joints in another order and the axes of some turned round.
/// @param joints  base, wrist and fingers of the Adroit hand; the base is not looked at
hand::JointVector shadow_joints(const RelocateJoints& joints);

/// The inverse, with the arm's joints at 0.
RelocateJoints task_joints(const hand::JointVector& shadow_joints);

/// The relocate task's hand as links, in the joints of the Shadow hand. Its mount is at the
/// forearm's origin, with the world's axes where the arm is at rest: fingers along +y, palm down.
/// Its fingertips are the capsules that the task has for them.
/// @throws BadInput if it is not the Adroit hand
hand::Description adroit_hand_model(const RelocateModel& model);

/// Puts tactile sensors on the fingertips of the relocate task's hand, as noisy as those of the
/// simulated Shadow hand. The published task has none; the physics is left alone.
class RelocateTouch {
 public:
  /// @param seed  of the noise, and of where the links really are
  RelocateTouch(const RelocateModel& model, const simulation::SensorNoise& noise,
                std::uint64_t seed);

  /// The hand as an estimator knows it: its links are off by SensorNoise::link.
  const hand::Description& hand_model() const { return hand_; }

  /// The reading after `step` steps: joints, mount, torques, the force on the mount without the
  /// hand's weight and inertia, and the fingertips' contacts with the object. The mount is measured
  /// without noise.
  hand::HandReading read(const RelocateTask& task, int step) const;

 private:
  simulation::SensorNoise noise_;
  RandomStream random_;
  hand::Description hand_;
  std::shared_ptr<const TaskArm> arm_;
  std::vector<int> tips_;  ///< geoms
};

}  // namespace palpate::relocate
