// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/estimate.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {

/// Estimates the object's pose in the hand from the robot's log: where the fingers have met it, or
/// where it hangs.
class PosePhase : public Phase {
 public:
  explicit PosePhase(estimation::PoseEstimator& estimator,
                     estimation::TouchEvent instant = estimation::TouchEvent::held)
      : estimator_(estimator), instant_(instant) {}
  std::string_view name() const override {
    return instant_ == estimation::TouchEvent::held ? "pose" : "estimate";
  }
  double time_limit() const override { return 1.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  estimation::PoseEstimator& estimator_;
  estimation::TouchEvent instant_;
};

}  // namespace palpate::skills
