// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/height_probe.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {

struct HeightProbeOptions {
  double start_height = 0.26;  ///< of the hand's base, m
  double speed = 0.10;         ///< downwards, m/s
  double touch_force = 0.7;    ///< N of load on the base
  double clearance = 0.012;    ///< stop this far above the table, m
  double travel_speed = 0.5;   ///< through the air, m/s
  double search = 0.10;        ///< where nothing is felt: this far to four sides of the place, m

  template <class Visitor>
  void visit(Visitor&& v) {
    v("start_height", start_height, 0.1, 0.5,
      "m, initial height of the mount above the table; more for hands that reach lower");
    v("speed", speed, 0.001, 0.5, "m/s, downward speed");
    v("touch_force", touch_force, 0.05, 20.0, "N, load on the mount that counts as a touch");
    v.expert("clearance", clearance, 0.0, 0.1, "m, nearest approach to the table");
    v.expert("search", search, 0.0, 0.3, "m, to the sides of a place where nothing is felt");
    v.expert("travel_speed", travel_speed, 0.01, 2.0, "m/s, through the air");
  }
};

/// Lowers the flat hand onto the object to feel how tall it is.
class HeightProbePhase : public Phase {
 public:
  explicit HeightProbePhase(const HeightProbeOptions& options) : options_(options) {}
  std::string_view name() const override { return "height_probe"; }
  double time_limit() const override { return 60.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  double start_height(const hand::Description& hand) const;
  bool lower(Executor& robot, PickState& state, const Eigen::Vector2d& place) const;

  HeightProbeOptions options_;
};

}  // namespace palpate::skills
