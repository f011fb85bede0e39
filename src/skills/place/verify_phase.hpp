// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/explore/height_probe_phase.hpp"

namespace palpate::skills {

/// Probes from above whether the object stands where it was put.
class VerifyPhase : public Phase {
 public:
  /// @param object  must outlive the phase
  VerifyPhase(const HeightProbeOptions& options, const geometry::KnownObject& object,
              const Eigen::Isometry3d& T_world_object)
      : options_(options), object_(object), T_world_object_(T_world_object) {
    options_.search = 0;
  }
  std::string_view name() const override { return "verify"; }
  double time_limit() const override { return 30.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  HeightProbeOptions options_;
  const geometry::KnownObject& object_;
  Eigen::Isometry3d T_world_object_;
};

}  // namespace palpate::skills
