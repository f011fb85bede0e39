// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/explore/explore_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/hand/tip_forces.hpp"
#include "palpate/skills/stop_conditions.hpp"
#include "skills/explore/extents.hpp"
#include "skills/explore/guarded_moves.hpp"
#include "skills/explore/pointing_finger.hpp"
#include "skills/motion/lowest_part.hpp"
#include "skills/motion/motion_constants.hpp"
#include "skills/motion/take_posture.hpp"
#include "skills/motion/touch_detector.hpp"

namespace palpate::skills {
namespace {

constexpr double kHollow = 0.05;          // m of a hand between whose fingers an object may stand
constexpr double kFarBelow = 0.03;        // m of its top, where such a hand may be stopped
constexpr double kClearanceAbove = 0.02;  // m of the hand over the object while travelling
constexpr double kContactSeconds = 0.12;  // s of contact that are averaged
constexpr double kBlockedLoad = 0.15;  // N more on the mount: something but the fingertip touches
constexpr int kBlockedMoves = 2;     // of a hand that sensed nothing, before its finger is changed
constexpr double kElsewhere = 0.05;  // of the posterior in no mode, that a travelling hand neglects
constexpr double kHigher = 0.006;    // m, of another try where the hand was blocked
constexpr double kHighest = 0.018;   // m, of all of these together
constexpr double kQuarters = 2;  // rad of a turn, from which the hand is turned by half of it, too
constexpr double kGoodSpread = 0.35;  // of the resting pose, where no more guarded moves are needed
constexpr double kWorthwhile = 0.93;  // of the spread that a guarded move may leave
constexpr double kBackOff = 0.015;    // m
constexpr double kEarlier = 0.015;    // m before the expected touch, from where a move is slow
constexpr double kOverTop = 0.005;    // m over the object, from where coming down is slower
constexpr double kRunUp = 0.02;       // m of a guarded move before that, which is fast
constexpr double kPast = 0.03;        // m behind the last place where a touch is expected
constexpr double kSettle = 0.08;      // s of standing still before a guarded move
constexpr double kGuardedMoveTime = 9;  // s that a guarded move takes with its travel, amply
constexpr double kMinTime = 180;        // s, of the whole phase

Executor::StopCondition tip_touches(int finger, double force) {
  return [finger, detector = TouchDetector(force)](const hand::HandReading& reading) mutable {
    return detector.update(hand::tip_force(reading, finger));
  };
}

/// Takes back most of the lead of the mount's command over where the mount is, which would go on
/// pushing.
void stop_here(Executor& robot, double speed) {
  hand::MountPosition here = robot.command().mount;
  here.xyz += kLeadTakenBack * (robot.reading().mount.xyz - here.xyz);
  robot.move_mount(here, speed);
}

/// The even numbers below a count, then the odd ones.
std::vector<int> every_other_first(int count) {
  std::vector<int> order;
  for (int i = 0; i < count; i += 2) order.push_back(i);
  for (int i = 1; i < count; i += 2) order.push_back(i);
  return order;
}

/// Whether one pose is left, and not a family of them.
bool settled(const localization::Posterior& posterior, double certain) {
  return localization::best_probability(posterior) > certain;
}

/// How to probe: with the first finger that can point and whose fingertip can be believed.
std::size_t first_trusted(const Executor& robot) {
  const auto& pointing = robot.model().postures.pointing;
  const auto found = std::find_if(pointing.begin(), pointing.end(), [&](const auto& hand) {
    return robot.trust().trusted(hand.finger);
  });
  return found == pointing.end() ? 0 : static_cast<std::size_t>(found - pointing.begin());
}

}  // namespace

double ExplorePhase::time_limit() const {
  const int guarded_moves =
      std::max(options_.max_touches, 2 * options_.touches) + options_.refining;
  return std::max(kMinTime, kGuardedMoveTime * guarded_moves);
}

const hand::PointingHand& ExplorePhase::pointing(const Executor& robot) const {
  return robot.model().postures.pointing.at(probe_);
}

double ExplorePhase::yaw(std::size_t turn) const { return kTurns.at(turn) * options_.turn; }

PhaseEnd ExplorePhase::run(Executor& robot, PickState& state) {
  done_.clear();
  raised_ = 0;
  blocked_ = 0;
  top_ = 0;
  if (hollow_depth(robot.model()) > kHollow) {
    const double top = estimator_.probable_top(robot.model(), robot.log());
    if (top > state.height + kFarBelow) state.height = top;
  }
  hand::MountPosition up = robot.command().mount;
  up.xyz.z() = std::max(up.xyz.z(), state.height + 0.2);
  probe_ = first_trusted(robot);
  const auto& hand = pointing(robot);
  const double low =
      lowest_on_way(robot.model(), robot.command().positions, attitude_of(robot.command().mount),
                    hand.positions, {hand.attitude.pitch, hand.attitude.roll});
  up.xyz.z() = std::max(up.xyz.z(),
                        likely_top(estimator_.candidates(), state.height) + kClearanceAbove - low);
  robot.move_mount(up, options_.travel_speed);
  take_posture(robot, pointing(robot).positions, 0.5);
  robot.wait(0.1);
  int touches = touch_around(robot, state);
  while (touches == 0 && blocked_ >= kBlockedMoves) touches = touch_with_another(robot, state);
  if (options_.max_touches <= options_.touches) touches += touch_between(robot, state, touches);
  estimate(robot, state);
  touches += disambiguate(robot, state);
  touches += refine(robot, state);
  if (state.resting->modes.empty()) {
    state.resting.reset();
    return {false, fmt::format("no pose explains the {} touches", touches)};
  }
  return {true, fmt::format("{} touches, {} ({:.2f})", touches,
                            localization::to_string(state.resting->status),
                            localization::best_probability(*state.resting))};
}

void ExplorePhase::estimate(Executor& robot, PickState& state) {
  state.resting = estimator_.resting(robot.model(), robot.log());
  const auto objects = possible_objects(estimator_);
  top_ = highest_of(objects);
  if (mass_elsewhere(objects) > kElsewhere) {
    top_ = std::max(top_, likely_top(estimator_.candidates(), state.height));
  }
  robot.show(*state.resting);
}

/// Level guarded moves from all sides, half of them with the hand turned round; each is aimed by
/// what the touches before it have shown.
int ExplorePhase::touch_around(Executor& robot, PickState& state) {
  int touches = 0;
  for (const int i : every_other_first(options_.touches)) {
    if (touches > 0) estimate(robot, state);
    const double angle = 2 * std::numbers::pi * i / options_.touches;
    touches += touch_from(robot, state, angle, i % 2 == 0 ? 0 : 1) == GuardedMoveEnd::touched;
  }
  return touches;
}

/// Once more, for the hand was blocked and the fingertip sensed nothing: it may be insensitive.
int ExplorePhase::touch_with_another(Executor& robot, PickState& state) {
  const int insensitive = pointing(robot).finger;
  robot.distrust(insensitive,
                 fmt::format("{} does not sense what blocks the hand",
                             robot.model().fingers[static_cast<std::size_t>(insensitive)].name));
  probe_ = first_trusted(robot);
  if (!robot.trust().trusted(pointing(robot).finger)) {
    robot.stop_for(Fault::touch_lost, "no finger that can probe senses what blocks the hand");
  }
  blocked_ = 0;
  hand::MountPosition up = robot.command().mount;
  up.xyz.z() = std::max(up.xyz.z(), state.height + 0.2);
  robot.move_mount(up, options_.travel_speed);
  take_posture(robot, pointing(robot).positions, 0.5);
  robot.wait(0.1);
  return touch_around(robot, state);
}

/// Level guarded moves from in between the first ones, till as many have touched as were asked for.
int ExplorePhase::touch_between(Executor& robot, const PickState& state, int touches) {
  int made_up = 0;
  for (const int i : every_other_first(options_.touches)) {
    if (touches + made_up >= options_.touches) break;
    const double angle = 2 * std::numbers::pi * (i + 0.5) / options_.touches;
    const auto end = touch_from(robot, state, angle, i % 2 == 0 ? 0 : 1);
    if (end == GuardedMoveEnd::timed_out) break;
    made_up += end == GuardedMoveEnd::touched;
  }
  return made_up;
}

/// A level guarded move. Where another part of the hand meets the object first, the finger was too
/// low: once more a little higher, and so are the guarded moves after it. One that misses goes
/// back.
ExplorePhase::GuardedMoveEnd ExplorePhase::touch_from(Executor& robot, const PickState& state,
                                                      double angle, std::size_t turn) {
  const double before = raised_;
  while (true) {
    const double depth = first_depth(state, options_) + raised_;
    const Eigen::Vector2d middle = middle_of(state, estimator_.object().object());
    const auto move = level_guarded_move(middle, options_, angle, 0, depth);
    const auto end = guarded_move(robot, state, {move, turn});
    if (end == GuardedMoveEnd::missed) raised_ = std::max(0.0, before - kHigher);
    if (end != GuardedMoveEnd::blocked) return end;
    if (raised_ + kHigher > kHighest + 1e-9) {
      raised_ = before;
      ++blocked_;
      return end;
    }
    raised_ += kHigher;
  }
}

/// The probing finger for each turn of the hand.
std::vector<localization::ProbingFinger> ExplorePhase::turned_fingers(const Executor& robot) const {
  std::vector<localization::ProbingFinger> fingers;
  const std::size_t turns = std::abs(options_.turn) > kQuarters ? kTurns.size() : 2;
  for (std::size_t turn = 0; turn < turns; ++turn) {
    fingers.push_back(probing_finger(robot, pointing(robot), yaw(turn)));
  }
  return fingers;
}

/// Touches where the modes differ most, one after the other, till one of them is left.
int ExplorePhase::disambiguate(Executor& robot, PickState& state) {
  int touches = 0;
  UntriedMoves untried;
  const auto all = disambiguating_moves(state, options_, travel_height(robot, state));
  std::fill_n(untried.begin(), options_.touches > 1 ? untried.size() : 1, all);
  for (int i = options_.touches; i < options_.max_touches; ++i) {
    if (state.resting->modes.empty() || settled(*state.resting, options_.certain)) break;
    const auto move =
        take_most_informative(possible_objects(estimator_), turned_fingers(robot), untried);
    if (!move) break;
    touches += guarded_move(robot, state, *move) == GuardedMoveEnd::touched;
    estimate(robot, state);
  }
  return touches;
}

/// Touches that lessen the error of the best pose most.
int ExplorePhase::refine(Executor& robot, PickState& state) {
  int touches = 0;
  std::vector<localization::GuardedMove>
      guarded_moves;  // near the top, where nothing but the fingertip meets the object
  add_level_guarded_moves(state, options_, first_depth(state, options_) + raised_, guarded_moves);
  for (int i = 0; i < options_.refining; ++i) {
    if (state.resting->modes.empty()) break;
    const auto choice = localization::most_refining_move(
        estimator_.object(), state.resting->modes[0].T_frame_object, turned_fingers(robot),
        guarded_moves, done_, kWorthwhile);
    if (!choice || choice->before < kGoodSpread) break;
    touches += guarded_move(robot, state, choice->guarded_move) == GuardedMoveEnd::touched;
  }
  if (touches > 0) {
    estimate(robot, state);
  }
  return touches;
}

/// m above the table of the probing fingertip's centre, while the hand travels over the object.
double ExplorePhase::travel_height(const Executor& robot, const PickState& state) const {
  const double top = top_ > 0 ? top_ : likely_top(estimator_.candidates(), state.height);
  return top + kClearanceAbove + tip_above_lowest(robot, pointing(robot));
}

/// m of a motion along which the object cannot be met, as far as is known; all of it where it meets
/// none.
double ExplorePhase::clear_way(const Executor& robot, const PickState& state,
                               const localization::TurnedMove& turned) const {
  const localization::GuardedMove& move = turned.guarded_move;
  const double length = (move.to - move.from).norm();
  if (state.resting && !state.resting->modes.empty()) {
    const auto finger = probing_finger(robot, pointing(robot), yaw(turned.turn));
    const double clear = localization::clear_way(possible_objects(estimator_), finger, move);
    return clear < length ? clear - kEarlier : clear;
  }
  if (robot.log().at(estimation::TouchEvent::fallen)) return 0;  // it may be anywhere
  const double reach = likely_reach(estimator_.candidates(), state.height);
  const double out = (move.from.head<2>() - state.place).norm();
  const double clear = out - reach - estimator_.options().resting_half_width - kEarlier;
  const bool down = move.to.head<2>() == move.from.head<2>();
  return down && clear > 0 ? length : clear;
}

/// Without most of the ways, before and behind, along which it can meet none of the credible poses.
localization::GuardedMove ExplorePhase::shortened(const Executor& robot, const PickState& state,
                                                  const localization::TurnedMove& turned) const {
  localization::GuardedMove move = turned.guarded_move;
  const Eigen::Vector3d way = move.to - move.from;
  if (!state.resting || state.resting->modes.empty() || way.z() != 0) return move;
  const auto finger = probing_finger(robot, pointing(robot), yaw(turned.turn));
  const double useful = localization::useful_way(possible_objects(estimator_), finger, move);
  if (useful + kPast < way.norm()) move.to = move.from + (useful + kPast) * way.normalized();
  const double clear = clear_way(robot, state, turned) - kRunUp;
  if (clear > 0 && clear < way.norm() - kRunUp - kEarlier) move.from += clear * way.normalized();
  return move;
}

/// Travels over the object, comes down to where the guarded move begins, makes it, and goes back.
ExplorePhase::GuardedMoveEnd ExplorePhase::guarded_move(Executor& robot, const PickState& state,
                                                        const localization::TurnedMove& turned) {
  const localization::GuardedMove move = shortened(robot, state, turned);
  const auto mount_at = [&](const Eigen::Vector3d& tip) {
    return mount_for_probe(robot, pointing(robot), yaw(turned.turn), tip);
  };
  Eigen::Vector3d above = move.from;
  above.z() = std::max(above.z(), travel_height(robot, state));
  for (const Eigen::Vector3d& tip : {above, move.from, move.to}) {
    if (!robot.obstacle(mount_at(tip)).empty()) return GuardedMoveEnd::missed;  // no information
  }
  robot.move_mount(mount_at(above), options_.travel_speed);
  const localization::TurnedMove descent{{above, move.from}, turned.turn};
  GuardedMoveEnd end = come_down(robot, state, descent);
  const bool there = end == GuardedMoveEnd::missed;
  const localization::TurnedMove shorter{move, turned.turn};
  if (there) {
    const double clear = clear_way(robot, state, shorter);
    end = move_until_contact(robot, shorter, clear,
                             speed_of_touch(estimator_.candidates(), options_));
  }
  if (end == GuardedMoveEnd::timed_out) return end;
  go_back(robot, there ? move : descent.guarded_move, mount_at(above).xyz.z());
  return end;
}

/// Fast over the object, slower as far as it cannot be there, and from there on as a guarded move.
/// One that meets nothing has missed; what is met where it cannot be is sensed all the same.
ExplorePhase::GuardedMoveEnd ExplorePhase::come_down(Executor& robot, const PickState& state,
                                                     const localization::TurnedMove& descent) {
  const localization::GuardedMove& move = descent.guarded_move;
  const double length = move.from.z() - move.to.z();
  const double clear = std::clamp(clear_way(robot, state, descent), 0.0, length);
  bool touched = false;
  const auto stopped = [&](double down, double speed) {
    const Eigen::Vector3d to = move.from - down * Eigen::Vector3d::UnitZ();
    return robot.move_mount(
               mount_for_probe(robot, pointing(robot), yaw(descent.turn), to), speed,
               [&, tip = tip_touches(pointing(robot).finger, options_.touch_force),
                hit = impact(robot, -Eigen::Vector3d::UnitZ())](const auto& reading) mutable {
                 touched = tip(reading);
                 return hit(reading) || touched;
               }) == MotionEnd::stopped;
  };
  const double over = std::min(clear, kClearanceAbove - kOverTop);
  if (stopped(over, options_.travel_speed / 2) || stopped(clear, options_.speed)) {
    robot.add_event(estimation::TouchEvent::guarded_move);
    return end_of(robot, descent, touched, MotionEnd::stopped);
  }
  robot.wait(kSettle);
  if (clear >= length) return GuardedMoveEnd::missed;
  const Eigen::Vector3d from(move.from.x(), move.from.y(), move.from.z() - clear);
  return move_until_contact(robot, {{from, move.to}, descent.turn}, 0, options_.speed / 2);
}

/// Along a guarded move at whose start the fingertip is, until something is met: fast at first, and
/// with the speed of a touch from `clear` (m) on.
ExplorePhase::GuardedMoveEnd ExplorePhase::move_until_contact(
    Executor& robot, const localization::TurnedMove& turned, double clear, double touch_speed) {
  const localization::GuardedMove& move = turned.guarded_move;
  const Eigen::Vector3d forward = (move.to - move.from).normalized();
  robot.add_event(estimation::TouchEvent::guarded_move);
  bool touched = false;
  const auto move_to = [&](const Eigen::Vector3d& to, double speed) {
    const auto tip = tip_touches(pointing(robot).finger, options_.touch_force);
    return robot.move_mount(
        mount_for_probe(robot, pointing(robot), yaw(turned.turn), to), speed,
        [&, blocked = rising_load(robot, forward, kBlockedLoad),
         hit = impact(robot, forward)](const hand::HandReading& reading) mutable {
          touched = tip(reading);
          const bool stopped = blocked(reading);
          return hit(reading) || touched || stopped;
        });
  };
  MotionEnd motion = move_to(move.from + std::max(0.0, clear) * forward, options_.speed);
  if (motion == MotionEnd::reached) motion = move_to(move.to, touch_speed);
  return end_of(robot, turned, touched, motion);
}

/// Notes how a guarded move has ended; a touch is held for as long as its contact is averaged.
ExplorePhase::GuardedMoveEnd ExplorePhase::end_of(Executor& robot,
                                                  const localization::TurnedMove& turned,
                                                  bool touched, MotionEnd motion) {
  if (motion == MotionEnd::timed_out) return GuardedMoveEnd::timed_out;  // it missed nothing
  if (motion == MotionEnd::stopped) stop_here(robot, options_.travel_speed);
  if (touched) {
    robot.wait(kContactSeconds);
    done_.push_back(turned);
  }
  robot.add_event(touched ? estimation::TouchEvent::touched : estimation::TouchEvent::missed);
  if (touched) return GuardedMoveEnd::touched;
  return motion == MotionEnd::stopped ? GuardedMoveEnd::blocked : GuardedMoveEnd::missed;
}

/// Back from where a guarded move has ended, and up.
void ExplorePhase::go_back(Executor& robot, const localization::GuardedMove& move,
                           double height) const {
  hand::MountPosition back = robot.command().mount;
  back.xyz -= kBackOff * (move.to - move.from).normalized();
  robot.move_mount(back, options_.travel_speed / 4);
  back.xyz.z() = std::max(back.xyz.z(), height);
  robot.move_mount(back, options_.travel_speed);
}

}  // namespace palpate::skills
