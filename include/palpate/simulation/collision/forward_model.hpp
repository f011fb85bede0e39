// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "palpate/simulation/world/world.hpp"
#include "palpate/skills/forward_model.hpp"

namespace palpate::simulation {

/// The forward model in MuJoCo: a second world, made of the object's mesh and the believed hand.
class SimulatedForwardModel final : public skills::ForwardModel {
 public:
  /// @throws BadInput for options or an object that cannot be simulated
  SimulatedForwardModel(const geometry::KnownObject& object, const hand::Description& believed,
                        const WorldOptions& options);
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
  /// @param rollouts  of the forward models' worlds; their noise is not used
  explicit SimulatedModels(const WorldOptions& rollouts = {}) : rollouts_(rollouts) {}

  [[nodiscard]] std::unique_ptr<planning::CollisionChecker> collision_checker(
      const geometry::KnownObject& object, const hand::Description& believed,
      const planning::CollisionOptions& options, const planning::Fixture& fixture) const override;
  [[nodiscard]] std::unique_ptr<skills::ForwardModel> forward_model(
      const geometry::KnownObject& object, const hand::Description& believed) const override;

 private:
  WorldOptions rollouts_;
};

}  // namespace palpate::simulation
