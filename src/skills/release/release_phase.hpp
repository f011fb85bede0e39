// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/release/set_down_phase.hpp"

namespace palpate::skills {

/// After a grasp that failed: sets down what may be left in the hand, opens, and rises. The place
/// of the last contacts becomes the object's rough place.
class ReleasePhase : public Phase {
 public:
  std::string_view name() const override { return "release"; }
  double time_limit() const override { return 20.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;
};

/// After the object has fallen out of the hand: rises as it is, then opens and turns level.
class ClearPhase : public Phase {
 public:
  std::string_view name() const override { return "clear"; }
  double time_limit() const override { return 30.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;
};

/// Opens around an object that the hand has grasped and not lifted.
class OpenPhase : public Phase {
 public:
  explicit OpenPhase(const LowerOptions& options) : options_(options) {}
  std::string_view name() const override { return "open"; }
  double time_limit() const override { return 30.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  LowerOptions options_;
};

}  // namespace palpate::skills
