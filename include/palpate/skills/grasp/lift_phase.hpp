// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/phase.hpp"

namespace palpate::skills {

struct LiftOptions {
  double height = 0.10;        ///< m
  double speed = 0.10;         ///< m/s
  double trial_height = 0.01;  ///< m, of the first part, in which a weak grip shows
  double trial_speed = 0.03;   ///< m/s, of that part
  double settle = 0.5;         ///< s of rest before the hold is evaluated
  double hold = 2.0;           ///< s
  double min_weight = 0.5;     ///< share of the object's weight that must hang in the hand
  int min_fingers = 2;         ///< that touch at the end: one alone cannot squeeze
  double touch_force = 0.1;    ///< N in the mean that is a touch, as where contacts are counted
  double max_slip = 0.012;  ///< m, of a fingertip's contact along it in the hold: as in transport

  template <class Visitor>
  void visit(Visitor&& v) {
    v("height", height, 0.01, 0.3, "m, height of the lift");
    v("speed", speed, 0.001, 0.5, "m/s, speed of the lift");
    v.expert("trial_height", trial_height, 0.0, 0.3,
             "m, of the lift's first part, in which a weak grip shows");
    v.expert("trial_speed", trial_speed, 0.001, 0.5, "m/s, speed of the lift's first part");
    v.expert("settle", settle, 0.0, 10.0, "s, rest before the hold is evaluated");
    v("hold", hold, 0.1, 60.0, "s, duration of the hold");
    v("min_weight", min_weight, 0.0, 1.0,
      "least share of the object's weight that the hand must carry");
    v("min_fingers", min_fingers, 0, 5,
      "least number of fingers in contact at the end of the hold");
    v.expert("touch_force", touch_force, 0.0, 5.0,
             "N, mean force above which a fingertip counts as touching");
    v("max_slip", max_slip, 1e-3, 0.1,
      "m, motion of a contact along its fingertip during the hold");
  }
};

/// Lifts, waits, and decides by touch and load whether the object is held: enough of its weight
/// hangs in the hand, enough fingers touch it, and it has not slipped along them during the hold.
/// It begins slowly, and a grip that gives way is noticed while the object still stands on the
/// table: the hand then goes back down and still holds what it held.
class LiftPhase : public Phase {
 public:
  /// @param weight  of the object, N
  LiftPhase(const LiftOptions& options, double weight) : options_(options), weight_(weight) {}
  std::string_view name() const override { return "lift"; }
  double time_limit() const override { return 20.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

  /// Whether the grip gave way before the object had been lifted off the table.
  [[nodiscard]] bool gave_way() const { return gave_way_; }

 private:
  bool tries(Executor& robot);

  LiftOptions options_;
  double weight_;
  bool gave_way_ = false;
};

}  // namespace palpate::skills
