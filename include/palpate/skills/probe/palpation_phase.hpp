// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/estimate.hpp"
#include "palpate/skills/grasp/grasp_phase.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {

struct PalpationOptions {
  int max = 3;            ///< touches of single fingers at most, before the lift; 0: none
  int regrasps = 2;       ///< at most, in all
  int table_touches = 4;  ///< of the held object and the table, at most; 0: none
  /// Weight of a pose up to which the closed hand palpates before it lifts; a better one is refined
  /// by the table, once the object hangs.
  double doubtful = 0.5;
  double certain = 0.8;          ///< weight of a pose that needs none
  double tight = 0.75;           ///< share of poses near the best one that needs no table
  double min_gain_rate = 0.025;  ///< nats/s of expected information, at least
  double opening = 0.5;       ///< of the proximal joint before a finger moves to another spot, rad
  double spread = 0.25;       ///< sideways, to either side, at most, rad
  double bend = 0.6;          ///< of the outer joints, to reach lower or higher, at most, rad
  double elsewhere = 0.006;   ///< m between spots of a finger that are not the same
  double likely = 0.6;        ///< chance of a touch at another spot that a move must have
  double closing_rate = 0.8;  ///< of the proximal joint, rad/s
  double torque = 0.06;       ///< N m at the proximal joint while closing
  double touch_force = 0.1;   ///< N at the fingertip
  double balance = 0.15;      ///< imbalance that the other fingers' forces may have
  double friction = 0.5;      ///< that their balance counts on

  [[nodiscard]] bool none() const { return max == 0 && regrasps == 0; }

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max", max, 0, 64, "number of touches of single fingers before the lift at most; 0: none");
    v("regrasps", regrasps, 0, 16,
      "number of regrasps from other sides at most, to distinguish poses");
    v("table_touches", table_touches, 0, 16,
      "number of touches of the table with the held object at most; 0: none");
    v.expert("doubtful", doubtful, 0.0, 1.0,
             "probability of the best pose up to which the hand probes before the lift");
    v("certain", certain, 0.0, 1.0,
      "probability of the best pose above which no more probes are made");
    v.expert(
        "tight", tight, 0.0, 1.0,
        "share of the credible poses within 2.5 deg and 3.5 mm of the best one above which the "
        "table is not touched");
    v("min_gain_rate", min_gain_rate, 0.0, 10.0,
      "nats/s, least expected information gain of an action");
    v.expert("opening", opening, 0.1, 1.5,
             "rad, opening of a finger's proximal joint before it moves to another point");
    v.expert("spread", spread, 0.0, 0.35,
             "rad, sideways motion of a finger to either side, at most");
    v.expert("bend", bend, 0.0, 1.5, "rad, bending of a finger's outer joints either way, at most");
    v.expert("elsewhere", elsewhere, 0.0, 0.05,
             "m, distance above which two points count as different");
    v.expert("likely", likely, 0.0, 1.0, "least probability that a motion touches a new point");
    v.expert("closing_rate", closing_rate, 0.05, 5.0,
             "rad/s, speed of the proximal joint while closing");
    v.expert("torque", torque, 0.01, 1.0, "N m, torque at the proximal joint while closing");
    v.expert("touch_force", touch_force, 0.02, 5.0,
             "N, force at the fingertip that counts as a touch");
    v.expert("balance", balance, 0.0, 2.0,
             "largest wrench residual of the other fingers' forces, without the finger that moves");
  }
};

/// Touches more of the object in the hand while its best pose is in doubt. Of all that could be
/// done the phase does what is expected to be most informative about the poses in question, a
/// second of the robot's time:
///
/// - before the lift, a finger that the others can do without touches another spot, and comes back;
/// - the object is let go and grasped from another side. Then the phase ends; the grasp is left to
///   who runs it (PickState::next_grasp).
class PalpationPhase : public Phase {
 public:
  /// @param instant  `closed`, the object still standing on the table, or `held`
  PalpationPhase(estimation::PoseEstimator& estimator, const PalpationOptions& options,
                 const GraspOptions& grasp,
                 estimation::TouchEvent instant = estimation::TouchEvent::closed)
      : estimator_(estimator), options_(options), grasp_(grasp), instant_(instant) {}
  std::string_view name() const override { return "probe"; }
  double time_limit() const override { return 60.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  estimation::PoseEstimator& estimator_;
  PalpationOptions options_;
  GraspOptions grasp_;
  estimation::TouchEvent instant_;
};

}  // namespace palpate::skills
