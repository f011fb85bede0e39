// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/localization/information/guarded_move_choice.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {

struct ExploreOptions {
  int touches = 8;            ///< guarded moves around the object; 0: none
  int max_touches = 16;       ///< with those that resolve what the first ones left open
  int refining = 4;           ///< at most, that make the best pose exact
  double certain = 0.97;      ///< weight of a pose that needs no more touches
  double turn = 3.14159265;   ///< of the hand for every other one of them, rad
  double radius = 0.135;      ///< of the circle from which they start, m
  double past = 0.05;         ///< how far they go past the object's place, m
  double speed = 0.10;        ///< of a guarded move where no touch is expected, m/s
  double touch_speed = 0.03;  ///< of a guarded move where one is, for up to 0.1 kg, m/s
  double touch_force = 0.1;   ///< N at the fingertip
  double travel_speed = 0.4;  ///< m/s
  double reach = 0.013;       ///< below the object's top, where only the fingertip touches, m

  template <class Visitor>
  void visit(Visitor&& v) {
    v("touches", touches, 0, 64, "number of guarded moves around the object; 0: none");
    v("max_touches", max_touches, 0, 64,
      "number of guarded moves at most, including those that distinguish the remaining poses; if "
      "not above `touches` (as with `palpate pick --explore`), none of these, but up to `touches` "
      "more from directions in between, in place of moves that touched nothing");
    v("refining", refining, 0, 64,
      "number of further guarded moves at most, which refine the best pose");
    v("certain", certain, 0.0, 1.0,
      "probability of the best pose above which no more touches are made");
    v.expert("turn", turn, -3.2, 3.2,
             "rad, rotation of the hand for every other guarded move; of more than 2, later ones "
             "by half");
    v.expert("radius", radius, 0.02, 0.3, "m, radius of the circle on which guarded moves start");
    v.expert("past", past, 0.0, 0.2,
             "m, distance that guarded moves continue past the object's position");
    v("speed", speed, 0.001, 0.2, "m/s, speed of a guarded move where no touch is expected");
    v("touch_speed", touch_speed, 0.001, 0.2,
      "m/s, speed of a guarded move where a touch is expected of an object of up to 0.1 kg; up to "
      "twice as fast for heavier ones");
    v("touch_force", touch_force, 0.02, 5.0, "N, force at the fingertip that counts as a touch");
    v.expert("travel_speed", travel_speed, 0.01, 2.0, "m/s, speed between guarded moves");
    v("reach", reach, 0.005, 0.07, "m, depth of the fingertip below the object's top");
  }
};

/// Touches the resting object from all sides with a stretched finger, gently enough not to move it,
/// and estimates how it lies. The hand keeps its posture and only travels, so that what is wrong
/// with the model of the finger shifts all contacts alike and leaves their shape. For every other
/// touch it is turned round, which turns that shift round, too, and so distinguishes it from the
/// object's place. A guarded move is fast where the object cannot be yet, by its size at first and
/// by its possible poses as soon as some touches show them, and slow from there on: a fast one
/// pushes it. So is the way down to a guarded move's start, and what stops that is a touch, too.
///
/// Where no moves are left to distinguish poses (max_touches <= touches), guarded moves without
/// contact are replaced by moves from directions in between, at most as many again.
class ExplorePhase : public Phase {
 public:
  ExplorePhase(estimation::PoseEstimator& estimator, const ExploreOptions& options)
      : estimator_(estimator), options_(options) {}
  std::string_view name() const override { return "explore"; }
  double time_limit() const override;
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  enum class GuardedMoveEnd { touched, missed, blocked, timed_out };
  GuardedMoveEnd guarded_move(Executor& robot, const PickState& state,
                              const localization::TurnedMove& turned);
  localization::GuardedMove shortened(const Executor& robot, const PickState& state,
                                      const localization::TurnedMove& turned) const;
  GuardedMoveEnd come_down(Executor& robot, const PickState& state,
                           const localization::TurnedMove& descent);
  GuardedMoveEnd move_until_contact(Executor& robot, const localization::TurnedMove& turned,
                                    double clear, double touch_speed);
  GuardedMoveEnd end_of(Executor& robot, const localization::TurnedMove& turned, bool touched,
                        MotionEnd motion);
  void go_back(Executor& robot, const localization::GuardedMove& move, double height) const;
  double travel_height(const Executor& robot, const PickState& state) const;
  double clear_way(const Executor& robot, const PickState& state,
                   const localization::TurnedMove& turned) const;
  const hand::PointingHand& pointing(const Executor& robot) const;
  double yaw(std::size_t turn) const;
  std::vector<localization::ProbingFinger> turned_fingers(const Executor& robot) const;
  /// Estimates the resting pose from all touches so far, and shows it.
  void estimate(Executor& robot, PickState& state);
  int touch_around(Executor& robot, PickState& state);
  int touch_with_another(Executor& robot, PickState& state);
  int touch_between(Executor& robot, const PickState& state, int touches);
  GuardedMoveEnd touch_from(Executor& robot, const PickState& state, double angle,
                            std::size_t turn);
  int disambiguate(Executor& robot, PickState& state);
  int refine(Executor& robot, PickState& state);

  estimation::PoseEstimator& estimator_;
  ExploreOptions options_;
  std::vector<localization::TurnedMove> done_;  // that touched
  std::size_t probe_ = 0;                       // which of Postures::pointing touches
  int blocked_ = 0;    // moves that ended against something that its fingertip did not sense
  double top_ = 0;     // m above the table, of the credible poses; 0: none is known
  double raised_ = 0;  // m, of the level guarded moves, where a lower hand was blocked
};

}  // namespace palpate::skills
