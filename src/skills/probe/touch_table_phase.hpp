// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/phase.hpp"
#include "palpate/skills/probe/palpation_phase.hpp"

namespace palpate::skills {

/// Lets the held object touch the table, turned to several sides, as long as that should show
/// something of its pose. The table meets its far ends, where an error of the orientation shows
/// most, and no error of the fingers' links bears on it (extrinsic contact; Kim et al.,
/// "Simultaneous tactile estimation and control of extrinsic contact", ICRA 2023).
class TouchTablePhase : public Phase {
 public:
  /// @param hold  s that the hand then stands still, before it records `held` again
  TouchTablePhase(estimation::PoseEstimator& estimator, const PalpationOptions& options,
                  double hold)
      : estimator_(estimator), options_(options), hold_(hold) {}
  std::string_view name() const override { return "touch_table"; }
  double time_limit() const override { return 60.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  estimation::PoseEstimator& estimator_;
  PalpationOptions options_;
  double hold_;
};

}  // namespace palpate::skills
