// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/pipeline/phase.hpp"

namespace palpate::pipeline {

/// Sets down what is left in the hand where it was grasped, opens, and rises. The place of the last
/// contacts becomes the object's rough place.
class ReleasePhase : public Phase {
 public:
  /// @param mark  `released` after a grasp that failed; `opened` where the object is to be grasped
  ///   anew and what is known of its pose still holds
  explicit ReleasePhase(Mark mark = Mark::released) : mark_(mark) {}
  std::string_view name() const override { return mark_ == Mark::opened ? "open" : "release"; }
  double time_limit() const override { return 20.0; }
  PhaseEnd run(Robot& robot, PickState& state) override;

 private:
  Mark mark_;
};

}  // namespace palpate::pipeline
