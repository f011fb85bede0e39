// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "palpate/estimation/height_probe.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {

struct HeightProbeOptions {
  double start_height = 0.26;  ///< of the hand's mount, m
  double speed = 0.10;         ///< downwards above anything that can stand there, m/s
  double touch_speed = 0.05;   ///< downwards below that, m/s
  double touch_force = 0.7;    ///< N of load on the mount
  double clearance = 0.012;    ///< stop this far above the table, m
  double travel_speed = 0.5;   ///< through the air, m/s
  double search = 0.10;        ///< m to all sides, half of it first, where nothing is touched

  template <class Visitor>
  void visit(Visitor&& v) {
    v("start_height", start_height, 0.1, 0.5,
      "m, height of the mount above the table at the start; raised for hands that reach lower");
    v("speed", speed, 0.001, 0.5, "m/s, downward speed above the tallest stable pose");
    v.expert("touch_speed", touch_speed, 0.001, 0.5,
             "m/s, downward speed below the tallest stable pose");
    v("touch_force", touch_force, 0.05, 20.0, "N, load on the mount that counts as a touch");
    v.expert("clearance", clearance, 0.0, 0.1, "m, least distance of the hand from the table");
    v.expert("search", search, 0.0, 0.3,
             "m, distance searched to each side if the hand reaches the table without a load");
    v.expert("travel_speed", travel_speed, 0.01, 2.0, "m/s, speed through the air");
  }
};

/// Lowers the flat hand onto the object to measure how tall it is.
class HeightProbePhase : public Phase {
 public:
  /// @param tallest  m above the table: what stands there is no taller. By default unknown
  explicit HeightProbePhase(const HeightProbeOptions& options,
                            double tallest = std::numeric_limits<double>::infinity())
      : options_(options), tallest_(tallest) {}
  std::string_view name() const override { return "height_probe"; }
  double time_limit() const override { return 240.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  double start_height(const hand::Description& hand, double clear_height) const;
  hand::MountPosition reachable(const Executor& robot, const PickState& state,
                                const Eigen::Vector2d& place) const;
  bool lower(Executor& robot, PickState& state, const Eigen::Vector2d& place) const;
  bool descend(Executor& robot) const;

  HeightProbeOptions options_;
  double tallest_;
};

}  // namespace palpate::skills
