// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/pipeline/locate.hpp"
#include "palpate/pipeline/phase.hpp"

namespace palpate::pipeline {

/// Estimates the pose of the held object from the robot's log.
class LocatePhase : public Phase {
 public:
  LocatePhase(const localization::ObjectModel& object, const LocateOptions& options,
              std::uint64_t seed)
      : object_(object), options_(options), seed_(seed) {}
  std::string_view name() const override { return "pose"; }
  double time_limit() const override { return 1.0; }
  PhaseEnd run(Robot& robot, PickState& state) override;

 private:
  const localization::ObjectModel& object_;
  LocateOptions options_;
  std::uint64_t seed_;
};

}  // namespace palpate::pipeline
