// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/explore/explore_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "palpate/hand/tip_forces.hpp"
#include "skills/explore/felt_size.hpp"
#include "skills/lowest_part.hpp"
#include "skills/motion_constants.hpp"
#include "skills/take_posture.hpp"
#include "skills/touch_detector.hpp"

namespace palpate::skills {
namespace {

constexpr double kClearanceAbove = 0.02;  // m of the hand over the object while travelling
constexpr double kMinDepth = 0.014;       // m of the fingertip's centre over the table
constexpr double kContactSeconds = 0.12;  // s of contact that are averaged
constexpr double kBlockedLoad = 0.15;     // N more on the base: something but the fingertip touches
constexpr int kDirections = 16;           // of further sweeps
constexpr int kOffsets = 3;               // to either side of the object's place
constexpr double kSpacing = 0.015;        // m between them
constexpr double kDepthStep = 0.02;       // m between heights of further sweeps
constexpr int kBlockedMoves = 2;  // of a hand that felt nothing, after which its finger is changed
constexpr double kMinInformation = 0.03;
constexpr double kHigher = 0.006;     // m, of another try where the hand was blocked
constexpr double kHighest = 0.018;    // m, of all of these together
constexpr double kGoodSpread = 0.35;  // of the resting pose, where no more guarded moves are needed
constexpr double kWorthwhile = 0.93;  // of the spread that a guarded move may leave
constexpr double kBackOff = 0.03;     // m
constexpr double kEarlier = 0.015;    // m before the expected touch, from where a sweep is slow
constexpr double kGuardedMoveTime = 9;  // s that a guarded move takes with its travel, amply
constexpr double kMinTime = 180;        // s, of the whole phase

/// Centre of the probing fingertip in the base's frame, by the posture read.
Eigen::Vector3d probe_in_base(const Executor& robot, const hand::PointingHand& pointing) {
  const auto T_base_link = hand::forward_kinematics(robot.model(), robot.reading().joints);
  const hand::Finger& finger = robot.model().fingers[static_cast<std::size_t>(pointing.finger)];
  return T_base_link[static_cast<std::size_t>(finger.link)] * finger.tip.b;
}

/// Base position, turned by a yaw, that brings the probing fingertip to p (world).
hand::BasePosition base_for_probe(const Executor& robot, const hand::PointingHand& pointing,
                                  double yaw, const Eigen::Vector3d& p) {
  hand::BasePosition base;
  base.ypr = {yaw, pointing.attitude.pitch, pointing.attitude.roll};
  base.xyz = p - base.pose().linear() * probe_in_base(robot, pointing);
  return base;
}

Executor::StopCondition tip_touches(int finger, double force) {
  return [finger, detector = TouchDetector(force)](const hand::HandReading& reading) mutable {
    return detector.update(hand::tip_force(reading, finger));
  };
}

/// Takes back most of the lead that the base's command has on the base, which would go on pushing.
void stop_here(Executor& robot, double speed) {
  hand::BasePosition here = robot.command().base;
  here.xyz += kLeadTakenBack * (robot.reading().base.xyz - here.xyz);
  robot.move_base(here, speed);
}

double first_depth(const PickState& state, const ExploreOptions& options) {
  return std::max(kMinDepth, state.height - options.reach);
}

/// Level towards the object's place from an angle, passing it to the left by an offset.
localization::GuardedMove level_guarded_move(const PickState& state, const ExploreOptions& options,
                                             double angle, double offset, double depth) {
  const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
  const Eigen::Vector3d middle = Eigen::Vector3d(state.place.x(), state.place.y(), depth) +
                                 offset * Eigen::Vector3d::UnitZ().cross(out);
  return {middle + options.radius * out, middle - options.past * out};
}

/// Level guarded moves from all sides, and past the object's place on both of them.
void add_level_guarded_moves(const PickState& state, const ExploreOptions& options, double depth,
                             std::vector<localization::GuardedMove>& guarded_moves) {
  for (int i = 0; i < kDirections; ++i) {
    for (int side = -kOffsets; side <= kOffsets; ++side) {
      guarded_moves.push_back(level_guarded_move(state, options,
                                                 2 * std::numbers::pi * i / kDirections,
                                                 kSpacing * side, std::max(kMinDepth, depth)));
    }
  }
}

/// Level ones from the least height of the fingertip up to the object's top, and downward ones.
/// @param above  m above the table, of a fingertip over the object
std::vector<localization::GuardedMove> telling_guarded_moves(const PickState& state,
                                                             const ExploreOptions& options,
                                                             double above) {
  std::vector<localization::GuardedMove> guarded_moves;
  for (double depth = first_depth(state, options); depth > kMinDepth - 0.5 * kDepthStep;
       depth -= kDepthStep) {
    add_level_guarded_moves(state, options, depth, guarded_moves);
  }
  for (int x = -kOffsets; x <= kOffsets; ++x) {
    for (int y = -kOffsets; y <= kOffsets; ++y) {
      const Eigen::Vector2d xy = state.place + kSpacing * Eigen::Vector2d(x, y);
      guarded_moves.push_back({{xy.x(), xy.y(), above}, {xy.x(), xy.y(), kMinDepth}});
    }
  }
  return guarded_moves;
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

std::vector<localization::PosedObject> possible_objects(
    const estimation::PoseEstimator& estimator) {
  std::vector<localization::PosedObject> objects;
  auto posteriors = estimator.posteriors();
  for (std::size_t i = 0; i < posteriors.size(); ++i) {
    objects.push_back({estimator.candidates()[i], std::move(posteriors[i])});
  }
  return objects;
}

/// m from the lowest part of the hand that points up to the centre of its fingertip.
double tip_above_lowest(const Executor& robot, const hand::PointingHand& pointing) {
  const hand::Attitude attitude{pointing.attitude.pitch, pointing.attitude.roll};
  const double tip = -base_for_probe(robot, pointing, 0, Eigen::Vector3d::Zero()).xyz.z();
  return tip - lowest_part(robot.model(), pointing.positions, attitude);
}

/// The probing finger's balls around the centre of its tip.
localization::ProbingFinger sweeping_finger(const Executor& robot,
                                            const hand::PointingHand& pointing, double yaw) {
  const auto& hand = robot.model();
  const auto T_base_link = hand::forward_kinematics(hand, robot.reading().joints);
  const Eigen::Matrix3d R_world_base =
      base_for_probe(robot, pointing, yaw, Eigen::Vector3d::Zero()).pose().linear();
  const Eigen::Vector3d tip_center = probe_in_base(robot, pointing);
  localization::ProbingFinger finger;
  finger.R_world_base = R_world_base;
  for (const auto& sphere : hand.spheres) {
    const Eigen::Vector3d p = T_base_link[static_cast<std::size_t>(sphere.link)] * sphere.center;
    const bool tip = sphere.link == hand.fingers[static_cast<std::size_t>(pointing.finger)].link;
    (tip ? finger.tip : finger.rest).push_back({R_world_base * (p - tip_center), sphere.radius});
  }
  return finger;
}

/// How to probe: with the first finger that can point and whose fingertip can be believed.
std::size_t first_trusted(const Executor& robot) {
  const auto& pointing = robot.model().postures.pointing;
  const auto found = std::find_if(pointing.begin(), pointing.end(),
                                  [&](const auto& hand) { return robot.trusted(hand.finger); });
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

PhaseEnd ExplorePhase::run(Executor& robot, PickState& state) {
  done_.clear();
  raised_ = 0;
  blocked_ = 0;
  hand::BasePosition up = robot.command().base;
  up.xyz.z() = std::max(up.xyz.z(), state.height + 0.2);
  robot.move_base(up, options_.travel_speed);
  probe_ = first_trusted(robot);
  take_posture(robot, pointing(robot).positions, 0.5);
  robot.wait(0.1);
  int touches = touch_around(robot, state);
  while (touches == 0 && blocked_ >= kBlockedMoves) touches = touch_with_another(robot, state);
  if (options_.max_touches <= options_.touches) touches += make_up(robot, state, touches);
  estimate(robot, state);
  touches += tell_apart(robot, state);
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
  robot.show(*state.resting);
}

/// Level guarded moves from all sides, half of them with the hand turned round.
int ExplorePhase::touch_around(Executor& robot, PickState& state) {
  int touches = 0;
  for (const int i : every_other_first(options_.touches)) {
    if (i == 1 && touches > 0) estimate(robot, state);
    const double angle = 2 * std::numbers::pi * i / options_.touches;
    touches += touch_from(robot, state, angle, i % 2 == 0 ? 0 : 1) == GuardedMoveEnd::touched;
  }
  return touches;
}

/// Once more, for the hand was blocked and the fingertip felt nothing: it may be numb.
int ExplorePhase::touch_with_another(Executor& robot, PickState& state) {
  robot.distrust(pointing(robot).finger);
  probe_ = first_trusted(robot);
  if (!robot.trusted(pointing(robot).finger)) {
    robot.stop_for(Fault::touch_lost, "no finger that can probe feels what blocks the hand");
  }
  blocked_ = 0;
  hand::BasePosition up = robot.command().base;
  up.xyz.z() = std::max(up.xyz.z(), state.height + 0.2);
  robot.move_base(up, options_.travel_speed);
  take_posture(robot, pointing(robot).positions, 0.5);
  robot.wait(0.1);
  return touch_around(robot, state);
}

/// Level guarded moves from in between the first ones, till as many have touched as were asked for.
int ExplorePhase::make_up(Executor& robot, const PickState& state, int touches) {
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

/// A level sweep. Where another part of the hand meets the object first, the finger was too low:
/// once more a little higher, and so are the sweeps after it. One that misses goes back.
ExplorePhase::GuardedMoveEnd ExplorePhase::touch_from(Executor& robot, const PickState& state,
                                                      double angle, std::size_t turn) {
  const double before = raised_;
  while (true) {
    const double depth = first_depth(state, options_) + raised_;
    const auto end =
        guarded_move(robot, state, {level_guarded_move(state, options_, angle, 0, depth), turn});
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

/// Touches where the modes differ most, one after the other, till one of them is left.
int ExplorePhase::tell_apart(Executor& robot, PickState& state) {
  int touches = 0;
  std::array<std::vector<localization::GuardedMove>, 2>
      left;  // for each turn of the hand: what was not tried yet
  left.fill(telling_guarded_moves(state, options_, travel_height(robot, state)));
  if (options_.touches <= 1) left[1].clear();
  for (int i = options_.touches; i < options_.max_touches; ++i) {
    if (state.resting->modes.empty() || settled(*state.resting, options_.certain)) break;
    std::optional<localization::InformativeMove> choice;
    std::size_t turn = 0;
    for (const std::size_t other : {1, 0}) {
      const auto best = localization::most_informative_move(
          possible_objects(estimator_), sweeping_finger(robot, pointing(robot), yaw(other)),
          left[other]);
      if (!best || (choice && best->information <= choice->information)) continue;
      choice = best;
      turn = other;
    }
    if (!choice || choice->information < kMinInformation) break;
    touches += guarded_move(robot, state, {choice->guarded_move, turn}) == GuardedMoveEnd::touched;
    left[turn].erase(left[turn].begin() + static_cast<std::ptrdiff_t>(choice->index));
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
  const std::vector<localization::ProbingFinger> fingers = {
      sweeping_finger(robot, pointing(robot), yaw(0)),
      sweeping_finger(robot, pointing(robot), yaw(1))};
  for (int i = 0; i < options_.refining; ++i) {
    if (state.resting->modes.empty()) break;
    const auto choice = localization::most_refining_move(
        estimator_.object(), state.resting->modes[0].T_frame_object, fingers, guarded_moves, done_);
    if (!choice || choice->before < kGoodSpread || choice->after > kWorthwhile * choice->before) {
      break;
    }
    touches += guarded_move(robot, state, choice->guarded_move) == GuardedMoveEnd::touched;
  }
  if (touches > 0) {
    estimate(robot, state);
  }
  return touches;
}

/// m above the table of the probing fingertip's centre, while the hand travels over the object.
double ExplorePhase::travel_height(const Executor& robot, const PickState& state) const {
  return likely_top(estimator_.candidates(), state.height) + kClearanceAbove +
         tip_above_lowest(robot, pointing(robot));
}

/// m of a sweep along which the object cannot be met, as far as is known.
double ExplorePhase::clear_way(const Executor& robot, const PickState& state,
                               const localization::TurnedMove& turned) const {
  const localization::GuardedMove& move = turned.guarded_move;
  if (state.resting && !state.resting->modes.empty()) {
    const auto finger = sweeping_finger(robot, pointing(robot), yaw(turned.turn));
    return localization::clear_way(possible_objects(estimator_), finger, move) - kEarlier;
  }
  if (robot.log().at(estimation::TouchEvent::fallen)) return 0;  // it may be anywhere
  const double reach = likely_reach(estimator_.candidates(), state.height);
  const double out = (move.from.head<2>() - state.place).norm();
  return out - reach - estimator_.options().resting_half_width - kEarlier;
}

ExplorePhase::GuardedMoveEnd ExplorePhase::guarded_move(Executor& robot, const PickState& state,
                                                        const localization::TurnedMove& turned) {
  const localization::GuardedMove& guarded_move = turned.guarded_move;
  const Eigen::Vector3d forward = (guarded_move.to - guarded_move.from).normalized();
  const hand::BasePosition start =
      base_for_probe(robot, pointing(robot), yaw(turned.turn), guarded_move.from);
  const hand::BasePosition end =
      base_for_probe(robot, pointing(robot), yaw(turned.turn), guarded_move.to);
  hand::BasePosition above = start;
  above.xyz.z() += std::max(0.0, travel_height(robot, state) - guarded_move.from.z());
  for (const hand::BasePosition& base : {above, start, end}) {  // not begun: it tells nothing
    if (!robot.obstacle(base).empty()) return GuardedMoveEnd::missed;
  }
  robot.move_base(above, options_.travel_speed);
  robot.move_base(start, options_.travel_speed / 2);
  robot.wait(0.15);
  robot.mark(estimation::TouchEvent::guarded_move);
  bool touched = false;
  const auto sweep_to = [&](const hand::BasePosition& base, double speed) {
    const auto tip = tip_touches(pointing(robot).finger, options_.touch_force);
    const auto blocked = rising_load(robot, forward, kBlockedLoad);
    return robot.move_base(base, speed, [&](const hand::HandReading& reading) {
      touched = tip(reading);
      return touched || blocked(reading);
    });
  };
  hand::BasePosition near = start;
  near.xyz += std::max(0.0, clear_way(robot, state, turned)) * forward;
  MotionEnd motion = sweep_to(near, options_.speed);
  if (motion == MotionEnd::reached) motion = sweep_to(end, options_.touch_speed);
  if (motion == MotionEnd::timed_out) return GuardedMoveEnd::timed_out;  // it missed nothing
  if (touched) {
    stop_here(robot, options_.travel_speed);
    robot.wait(kContactSeconds);
    done_.push_back(turned);
  }
  robot.mark(touched ? estimation::TouchEvent::touched : estimation::TouchEvent::missed);
  hand::BasePosition back = robot.command().base;
  back.xyz -= kBackOff * forward;
  robot.move_base(back, options_.travel_speed / 4);
  back.xyz.z() = std::max(back.xyz.z(), above.xyz.z());
  robot.move_base(back, options_.travel_speed);
  if (touched) return GuardedMoveEnd::touched;
  return motion == MotionEnd::stopped ? GuardedMoveEnd::blocked : GuardedMoveEnd::missed;
}

}  // namespace palpate::skills
