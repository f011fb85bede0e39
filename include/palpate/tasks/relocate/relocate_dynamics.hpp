// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <memory>

#include "palpate/tasks/relocate/relocate_task.hpp"

namespace palpate::relocate {

/// Rigid-body dynamics of the relocate task's arm and hand, without contacts: what torques a motion
/// takes, and which actions give them. Not for two threads at once.
class RelocateDynamics {
 public:
  static constexpr int kFingerJoints = 22;
  using FingerJoints = Eigen::Matrix<double, kFingerJoints, 1>;

  explicit RelocateDynamics(const RelocateModel& model);
  ~RelocateDynamics();

  const RelocateJoints& lower() const { return lower_; }  ///< m, rad; of the joints' ranges
  const RelocateJoints& upper() const { return upper_; }

  /// Where the body "palm" is at these joints.
  Eigen::Isometry3d palm(const RelocateJoints& q);

  /// Joints that put the palm there, the wrist straight; clipped to their ranges.
  RelocateJoints place_palm(const Eigen::Isometry3d& T_world_palm, const FingerJoints& fingers);

  /// Generalised forces that a motion takes (thesis eq. 7.9): of inertia, gravity, damping, and a
  /// load (kg) that the grasp carries along. N, N m.
  RelocateJoints torques(const RelocateJoints& q, const RelocateJoints& velocity,
                         const RelocateJoints& acceleration, double load = 0);

  /// Torques that press each fingertip towards a point (m, world axes) with a force (N).
  RelocateJoints press(const RelocateJoints& q, const Eigen::Vector3d& towards, double force);

  /// The action whose actuators exert these forces at this state; not clipped.
  RelocateAction action(const RelocateJoints& q, const RelocateJoints& velocity,
                        const RelocateJoints& torques) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  RelocateJoints lower_, upper_;
};

}  // namespace palpate::relocate
