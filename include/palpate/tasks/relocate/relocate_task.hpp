// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string_view>

#include "palpate/core/random.hpp"
#include "palpate/tasks/relocate/relocate_object.hpp"

namespace palpate::relocate {

/// Version of the task: hand, observation, action, reward and reset. Policies name it in their
/// files. Until relocate-1 the wrist's WRJ0 had ten times the published damping, and the arm stood
/// 50 mm nearer to the object; policies made there are still read.
inline constexpr std::string_view kRelocateVersion = "relocate-v2";
inline constexpr std::string_view kFormerRelocateVersion = "relocate-1";

inline constexpr int kRelocateJoints = 30;  ///< base x y z roll pitch yaw, wrist 2, fingers 22
inline constexpr int kRelocateObservations = 39;

using RelocateAction = Eigen::Matrix<double, kRelocateJoints, 1>;
using RelocateJoints = Eigen::Matrix<double, kRelocateJoints, 1>;

/// 30 joint positions (m, rad); palm - object; palm - target; object - target (m, world axes).
using RelocateObservation = Eigen::Matrix<double, kRelocateObservations, 1>;
inline constexpr int kPalmFromObject = 30, kPalmFromTarget = 33, kObjectFromTarget = 36;

/// How exactly the physics is solved. Training uses the fast ones; results are of the faithful one.
enum class RelocateSolver {
  faithful,  ///< projected Gauss-Seidel with slip removal, elliptic cones: the published task
  newton,    ///< Newton, elliptic cones
  fast       ///< Newton, pyramidal cones, 3 steps of physics each control step instead of 5
};

/// @throws BadInput for a name that is none of "faithful", "newton", "fast"
RelocateSolver relocate_solver(std::string_view name);
std::string_view to_string(RelocateSolver solver);

struct RelocatePhysics {
  RelocateSolver solver = RelocateSolver::faithful;
  double mass_scale = 1;      ///< of the object's mass and inertia
  double friction_scale = 1;  ///< of the sliding friction of everything
};

/// Where an episode starts: the object on the table and the place to bring it to.
struct RelocateStart {
  Eigen::Vector2d object = Eigen::Vector2d::Zero();       ///< of its frame's origin, m
  Eigen::Vector3d target = Eigen::Vector3d::Zero();       ///< m
  Eigen::Vector3d object_bias = Eigen::Vector3d::Zero();  ///< m, of the object's place as observed
  int observation_period = 0;      ///< control steps between, and delay of, what is observed of the
                                   ///< object in the grasp; 0: always the true position
  double encoder_noise = 0;        ///< m, rad; 0: proprioception has the true velocities
  std::uint64_t encoder_seed = 0;  ///< of that noise
};

/// Draws a start. The object's x is 0.15 s - 0.1, its y is within 0.15 s; the target does not
/// depend on the scale s.
/// @param scale  s, 0..1; the published task has 0.25
RelocateStart sample_relocate_start(RandomStream& random, double scale);

/// What a robot's own sensors measure beyond the observation.
struct Proprioception {
  RelocateJoints velocity = RelocateJoints::Zero();  ///< of the joints, m/s, rad/s
  RelocateJoints bias = RelocateJoints::Zero();  ///< force that holds the joints at rest, N, N m
};

struct RelocateStep {
  double reward = 0;
  double distance = 0;    ///< of the object from the target, m
  bool contact = false;   ///< of hand and object
  bool diverged = false;  ///< the physics failed or the action was not finite: the episode is over
};

/// The compiled task; immutable, shared by the tasks of all threads.
class RelocateModel {
 public:
  /// @throws BadInput if the hand's model is missing or the object cannot be simulated
  explicit RelocateModel(const RelocateObject& object, const RelocatePhysics& physics = {});

  /// An action of a commands the actuators to center + clip(a, -1, 1) * half_range.
  const RelocateAction& action_center() const;
  const RelocateAction& action_half_range() const;
  double object_mass() const;  ///< kg

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  std::shared_ptr<const Impl> impl_;
};

/// One episode after another of the relocate task: the Adroit hand brings an object from the table
/// to a target in the air. Control at 100 Hz, five steps of physics each (three on the fast
/// solver).
class RelocateTask {
 public:
  explicit RelocateTask(const RelocateModel& model);
  ~RelocateTask();
  RelocateTask(RelocateTask&&) noexcept;
  RelocateTask& operator=(RelocateTask&&) noexcept;

  /// @throws BadInput for a start that is not finite
  void reset(const RelocateStart& start);

  RelocateObservation observation() const;

  /// With encoder noise, velocities are the differences of noisy positions, low-pass filtered.
  Proprioception proprioception() const;
  RelocateStep step(const RelocateAction& action);

  /// All generalised positions (37), for drawing and tests.
  Eigen::VectorXd positions() const;

  struct Impl;
  const Impl& impl() const;  ///< for what senses or draws the task's simulator

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::relocate
