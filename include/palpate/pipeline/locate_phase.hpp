// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/pipeline/locate.hpp"
#include "palpate/pipeline/phase.hpp"

namespace palpate::pipeline {

/// Estimates the object's pose in the hand from the robot's log: where the fingers have met it, or
/// where it hangs.
class LocatePhase : public Phase {
 public:
  LocatePhase(const localization::ObjectModel& object, const LocateOptions& options,
              std::uint64_t seed, Mark instant = Mark::held)
      : object_(object), options_(options), seed_(seed), instant_(instant) {}
  std::string_view name() const override { return instant_ == Mark::held ? "pose" : "estimate"; }
  double time_limit() const override { return 1.0; }
  PhaseEnd run(Robot& robot, PickState& state) override;

 private:
  const localization::ObjectModel& object_;
  LocateOptions options_;
  std::uint64_t seed_;
  Mark instant_;
};

}  // namespace palpate::pipeline
