// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/track.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {

/// Follows the object from the closed hand through the lift, from the state's estimate on.
class TrackPhase : public Phase {
 public:
  TrackPhase(const geometry::ObjectModel& object, const estimation::TrackOptions& options,
             const tactile::ContactErrorModel& errors, std::uint64_t seed)
      : object_(object), options_(options), errors_(errors), seed_(seed) {}
  std::string_view name() const override { return "track"; }
  double time_limit() const override { return 1.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  const geometry::ObjectModel& object_;
  estimation::TrackOptions options_;
  tactile::ContactErrorModel errors_;
  std::uint64_t seed_;
};

}  // namespace palpate::skills
