// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/phase.hpp"

namespace palpate::skills {

struct CalibrateOptions {
  int touches = 40;           ///< of the bare table, one fingertip each; 0: none
  double x = -0.35, y = 0;    ///< where the table is bare, m; the forearm lies further towards -x
  double speed = 0.04;        ///< downwards, m/s
  double travel_speed = 0.5;  ///< through the air, m/s
  double touch_force = 0.1;   ///< N at the fingertip
  double rest = 0.25;         ///< s that the fingertip rests and is averaged
  double sigma = 0.0003;      ///< m, of a resting tip's height but for the links, at least

  template <class Visitor>
  void visit(Visitor&& v) {
    v("touches", touches, 0, 1000, "of the bare table, one fingertip each; 0: none");
    v("x", x, -0.8, 0.8, "m, where the table is bare");
    v("y", y, -0.8, 0.8, "m, where the table is bare");
    v("speed", speed, 0.001, 0.5, "m/s, downwards");
    v.expert("travel_speed", travel_speed, 0.01, 2.0, "m/s, through the air");
    v("touch_force", touch_force, 0.02, 5.0, "N at the fingertip");
    v.expert("rest", rest, 0.02, 5.0, "s that the fingertip rests and is averaged");
    v.expert("sigma", sigma, 1e-5, 0.02,
             "m, error of a resting tip's height but for the links, at least");
  }
};

/// The hand as the touches of the bare table in a log tell that it is (tactile::calibrate_links),
/// the table being z = 0. As it was given where there are none, or where they contradict one
/// another.
hand::Description calibrated_hand(const hand::Description& hand, const estimation::EventLog& log,
                                  const CalibrateOptions& options);

/// Finds out where the hand's links really are: touches the bare table, a plane that is known, with
/// one fingertip after the other in those attitudes that tell most about where fingertips are in
/// grasps, and gives the robot the calibrated hand.
class CalibratePhase : public Phase {
 public:
  explicit CalibratePhase(const CalibrateOptions& options) : options_(options) {}
  std::string_view name() const override { return "calibrate"; }
  double time_limit() const override;
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  CalibrateOptions options_;
};

}  // namespace palpate::skills
