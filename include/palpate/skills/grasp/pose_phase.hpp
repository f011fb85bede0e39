// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/estimate.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {

/// Estimates the object's pose in the hand from the robot's log: where the fingers have met it, or
/// where it hangs.
class LocatePhase : public Phase {
 public:
  LocatePhase(const geometry::ObjectModel& object, const estimation::LocateOptions& options,
              std::uint64_t seed, estimation::Mark instant = estimation::Mark::held)
      : object_(object), options_(options), seed_(seed), instant_(instant) {}
  std::string_view name() const override {
    return instant_ == estimation::Mark::held ? "pose" : "estimate";
  }
  double time_limit() const override { return 1.0; }
  PhaseEnd run(Robot& robot, PickState& state) override;

 private:
  const geometry::ObjectModel& object_;
  estimation::LocateOptions options_;
  std::uint64_t seed_;
  estimation::Mark instant_;
};

}  // namespace palpate::skills
