// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/phase.hpp"
#include "palpate/tactile/calibration/link_calibration.hpp"

namespace palpate::skills {

struct CalibrateOptions {
  int touches = 40;           ///< of the bare table, one fingertip each; 0: none
  double x = -0.35, y = 0;    ///< where the table is bare, m; the forearm lies further towards -x
  double speed = 0.06;        ///< downwards, m/s
  double travel_speed = 0.5;  ///< through the air, m/s
  double touch_force = 0.1;   ///< N at the fingertip
  double rest = 0.25;         ///< s that the fingertip rests and is averaged
  double sigma = 0.0003;      ///< m, of a resting tip's height but for the links, at least
  // Prior of what the touches then measure, standard deviations.
  double mount = 0.001;         ///< m, of where the arm carries the hand, per axis
  double mount_angle = 0.005;   ///< rad, per axis
  double table_height = 0.005;  ///< m, at the world's origin
  double table_tilt = 0.0175;   ///< rad, per axis

  template <class Visitor>
  void visit(Visitor&& v) {
    v("touches", touches, 0, 1000, "touches of the bare table, each by one fingertip; 0: none");
    v("x", x, -0.8, 0.8, "m, x of the bare area of the table");
    v("y", y, -0.8, 0.8, "m, y of the bare area of the table");
    v("speed", speed, 0.001, 0.5, "m/s, downward speed of the touches");
    v.expert("travel_speed", travel_speed, 0.01, 2.0, "m/s, speed through the air");
    v("touch_force", touch_force, 0.02, 5.0, "N, force at the fingertip that counts as a touch");
    v.expert("rest", rest, 0.02, 5.0,
             "s, rest of the fingertip over which its readings are averaged");
    v.expert("sigma", sigma, 1e-5, 0.02,
             "m, error of a resting tip's height besides that of the links, at least");
    v.expert("mount", mount, 0.0, 0.05, "m, assumed error of the hand's position on the arm");
    v.expert("mount_angle", mount_angle, 0.0, 0.2,
             "rad, assumed error of the hand's orientation on the arm");
    v.expert("table_height", table_height, 0.0, 0.03, "m, assumed error of the table's height");
    v.expert("table_tilt", table_tilt, 0.0, 0.1, "rad, assumed tilt of the table");
  }
};

/// Calibration of the hand and of the table by the touches of the bare table in a log, believed to
/// be z = 0 (tactile::calibrate_links). As both were given where there are none, or where they
/// contradict one another.
tactile::HandCalibration calibration(const hand::Description& hand, const estimation::EventLog& log,
                                     const CalibrateOptions& options);

/// The hand of calibration(); the log gets the table's tilt.
hand::Description calibrated_hand(const hand::Description& hand, estimation::EventLog& log,
                                  const CalibrateOptions& options);

/// Calibrates where the hand's links really are, how the arm carries it, where the table is, and
/// what the mount's load reads where nothing loads it: touches the bare table with one fingertip
/// after the other in those attitudes that are most informative about where fingertips are in
/// grasps. The robot gets the calibrated hand; from then on z = 0 is the table.
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
