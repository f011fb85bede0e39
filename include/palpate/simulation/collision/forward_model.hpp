// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "palpate/simulation/world/world.hpp"
#include "palpate/skills/forward_model.hpp"

namespace palpate::simulation {

/// The world of a forward model. Its readings are exact, and nothing differs from what the robot
/// believes but what is said here.
struct ForwardModelOptions {
  double time_step = 0.002;      ///< s
  double hand_friction = 0.5;    ///< sliding, hand against object, as the robot believes it
  double table_friction = 0.5;   ///< sliding, object against table
  double stiffness_scale = 4.0;  ///< of the fingers' position controllers
  bool exact_tips = true;        ///< tips meet the true surface, the table its hull; else the parts

  template <class Visitor>
  void visit(Visitor&& v) {
    v("time_step", time_step, 1e-4, 0.01, "s, time step of the physics");
    v("table_friction", table_friction, 0.0, 5.0, "friction coefficient of table and object");
    v("stiffness_scale", stiffness_scale, 0.1, 20.0,
      "factor on the stiffness of the fingers' position controllers");
    v("exact_tips", exact_tips,
      "compute contacts of fingertips on the true surface instead of convex parts");
  }
};

/// The forward model in MuJoCo: a second world, made of the object's mesh and the believed hand.
class SimulatedForwardModel final : public skills::ForwardModel {
 public:
  /// @throws BadInput for options or an object that cannot be simulated
  SimulatedForwardModel(const geometry::KnownObject& object, const hand::Description& believed,
                        const ForwardModelOptions& options);
  ~SimulatedForwardModel() override;
  SimulatedForwardModel(SimulatedForwardModel&&) noexcept;

  skills::RolloutOutcome settle(const skills::BelievedGrasp& grasp, double seconds) override;
  skills::RolloutOutcome rollout(std::span<const hand::HandCommand> motion) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Collision checkers and forward models in MuJoCo.
class SimulatedModels final : public skills::ModelFactory {
 public:
  /// @param rollouts  of the forward models' worlds
  explicit SimulatedModels(const ForwardModelOptions& rollouts = {}) : rollouts_(rollouts) {}

  [[nodiscard]] std::unique_ptr<planning::CollisionChecker> collision_checker(
      const geometry::KnownObject& object, const hand::Description& believed,
      const planning::CollisionOptions& options, const planning::Fixture& fixture) const override;
  [[nodiscard]] std::unique_ptr<skills::ForwardModel> forward_model(
      const geometry::KnownObject& object, const hand::Description& believed) const override;

 private:
  ForwardModelOptions rollouts_;
};

}  // namespace palpate::simulation
