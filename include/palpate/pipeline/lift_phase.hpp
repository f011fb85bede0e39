// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/pipeline/phase.hpp"

namespace palpate::pipeline {

struct LiftOptions {
  double way = 0.10;          ///< m
  double speed = 0.10;        ///< m/s
  double settle = 0.5;        ///< s of rest before the hold is judged
  double hold = 2.0;          ///< s
  double least_weight = 0.5;  ///< share of the object's weight that must hang in the hand

  template <class Visitor>
  void visit(Visitor&& v) {
    v("way", way, 0.01, 0.3, "m, upwards");
    v("speed", speed, 0.001, 0.5, "m/s");
    v("settle", settle, 0.0, 10.0, "s of rest before the hold is judged");
    v("hold", hold, 0.1, 60.0, "s");
    v("least_weight", least_weight, 0.0, 1.0, "share of the object's weight that must hang");
  }
};

/// Lifts, waits, and weighs what hangs in the hand by the load on the base.
class LiftPhase : public Phase {
 public:
  /// @param weight  of the object, N
  LiftPhase(const LiftOptions& options, double weight) : options_(options), weight_(weight) {}
  std::string_view name() const override { return "lift"; }
  double time_limit() const override { return 20.0; }
  PhaseEnd run(Robot& robot, PickState& state) override;

 private:
  LiftOptions options_;
  double weight_;
};

}  // namespace palpate::pipeline
