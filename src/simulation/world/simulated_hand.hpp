// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <utility>

#include "palpate/core/random.hpp"
#include "palpate/hand/arm_follower.hpp"
#include "palpate/hand/hand.hpp"
#include "simulation/world/scene.hpp"
#include "simulation/world/sensor_errors.hpp"
#include "simulation/world/simulated_biotacs.hpp"

namespace palpate::simulation {

/// The hand of a scene: drives its actuators and reads its noisy sensors.
class SimulatedHand : public hand::Hand {
 public:
  /// Keeps references: scene, data and description must outlive the hand.
  SimulatedHand(const Scene& scene, mjData& data, const hand::Description& hand,
                const WorldOptions& options, const RandomStream& random);

  hand::HandReading step(const hand::HandCommand& command) override;

  [[nodiscard]] hand::PathFeasibility check_path(
      std::span<const hand::MountPosition> way) const override;
  [[nodiscard]] hand::MountLimits mount_limits() const override;
  [[nodiscard]] hand::ArmPosture arm_posture() const override;

  /// The scene's arm carries the hand, instead of a floating mount.
  void mount_on(const hand::ArmDescription& arm) { follower_.emplace(arm); }

  /// Puts the hand, at rest, where the command wants it, and starts the noise again. The coupled
  /// joints J1 and J2 share J0 as in free flexion.
  void reset(const hand::HandCommand& command);

  /// From now on readings hold the channels of these.
  void wear(SimulatedBiotacs biotacs) { biotacs_.emplace(std::move(biotacs)); }

  /// The object moves at this velocity (m/s, world), whatever holds it, from now on.
  void push_object(const Eigen::Vector3d& velocity, double seconds);

  /// Calls the observer after every step of the physics; an empty one ends that.
  void observe(StepObserver observer) { observer_ = std::move(observer); }

 private:
  void apply(const hand::HandCommand& command);
  void integrate(const hand::HandCommand& command);
  void interpolate(const hand::ArmVector& from, double share);
  void step_physics();
  void carry_to(const hand::MountPosition& mount);
  void read_mount(hand::HandReading& reading);
  [[nodiscard]] Eigen::Vector3d flange_force() const;
  hand::HandReading read();
  void read_contacts(hand::HandReading& reading, RandomStream& random);

  const Scene& scene_;
  mjData& data_;
  const hand::Description& hand_;
  SensorNoise noise_;
  SensorErrors errors_;
  simulation::IntegralAction integral_;
  hand::ActuatorVector stiffness_;
  RandomStream random_;
  std::uint64_t tick_ = 0;
  Eigen::Vector3d push_ = Eigen::Vector3d::Zero();  // m/s
  int pushed_steps_ = 0;                            // of the physics that are left
  int steps_a_tick_;
  StepObserver observer_;
  std::optional<hand::ArmFollower> follower_;
  hand::MountPosition commanded_;  // in the world
  hand::MountLimits limits_;       // of a floating mount
  std::optional<SimulatedBiotacs> biotacs_;
};

}  // namespace palpate::simulation
