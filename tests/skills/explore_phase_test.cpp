// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/explore/explore_phase.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "hand/fake_hand.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"
#include "skills/explore/guarded_moves.hpp"

namespace palpate::skills {
namespace {

/// A hand that sweeps about a box, and touches something on the level sweeps that a rule names.
struct Exploring {
  using Rule = std::function<bool(std::size_t sweep)>;  // numbered from 0

  explicit Exploring(Rule touches,
                     const geometry::KnownObject& known = geometry::load_known_object("box"))
      : object(known),
        hand([this, touches = std::move(touches)](hand::HandReading& reading) {
          follow(reading.mount.xyz);
          if (fallen > roof && !sweeping) touch(reading, Eigen::Vector3d::UnitZ());
          if (!sweeping || way() < met || (!is_level() && !meets_on_the_way_down)) return;
          if (touches(sweeps)) touch(reading, (start - last).normalized());
          if (blocks && blocks(sweeps))
            reading.mount_force = obstacle * (last - start).normalized();
        }),
        robot(hand, model, hand::resting_command(),
              {{}, [this](estimation::TouchEvent event) { count(event); }, {}}) {
    locate.search.proposals = 2000;
    locate.search.particles = 100;
    options.refining = 0;
    options.radius = 0.2;         // so that sweeps begin where the box cannot be
    options.touch_speed = 0.015;  // twice that for the box, of 0.4 kg
    state.height = 0.05;
  }

  void follow(const Eigen::Vector3d& now) {
    const bool down = (now - last).head<2>().norm() < 1e-9 && now.z() < last.z();
    fallen = down ? fallen + last.z() - now.z() : 0;
    last = now;
  }
  [[nodiscard]] double way() const { return (last - start).norm(); }
  [[nodiscard]] bool is_level() const { return std::abs(last.z() - start.z()) < 0.1 * way(); }

  void count(estimation::TouchEvent event) {
    if (event == estimation::TouchEvent::guarded_move) {
      sweeping = true;
      start = last;
      begun = robot.command().mount;
    } else if (sweeping) {
      sweeping = false;
      if (!is_level()) return;
      ++sweeps;
      starts.push_back(begun);
    }
  }

  /// The fingertip meets a face of a normal (world).
  void touch(hand::HandReading& reading, const Eigen::Vector3d& normal) const {
    const auto link = static_cast<std::size_t>(model.fingers[1].link);
    const Eigen::Matrix3d R_link_world =
        (reading.mount.pose() * hand::forward_kinematics(model, reading.joints)[link])
            .linear()
            .transpose();
    const Eigen::Vector3d n = R_link_world * normal;
    reading.contacts[1] = {{model.fingers[1].tip.b - model.fingers[1].tip.radius * n, n, -n}};
  }

  PhaseReport explore() {
    estimation::PoseEstimator estimator(object, locate, 1);
    ExplorePhase phase(estimator, options);
    return run_phase(phase, robot, state);
  }
  std::size_t count_of(estimation::TouchEvent event) const { return robot.log().all(event).size(); }

  /// Sweeps that set out from the same place with the hand turned alike.
  std::size_t repeated() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        count += (starts[i].xyz - starts[j].xyz).norm() < 1e-6 &&
                 (starts[i].ypr - starts[j].ypr).norm() < 1e-6;
      }
    }
    return count;
  }

  double met = 0.1;       // m of a guarded move after which something is met
  double fallen = 0;      // m that the hand has come straight down in one go
  double roof = 1e9;      // m of it after which the fingertip meets something, but in sweeps
  double obstacle = 5.0;  // N, of what blocks the hand
  Rule blocks;            // where another part of the hand meets something
  bool meets_on_the_way_down = false;
  std::vector<hand::MountPosition> starts;  // of the level sweeps
  std::size_t sweeps = 0;                   // level ones that have ended
  bool sweeping = false;
  hand::MountPosition begun;
  Eigen::Vector3d start{0, 0, 0}, last{0, 0, 0};
  hand::Description model =
      hand::with_soft_actuators(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")));
  geometry::ObjectModel object;
  ExploreOptions options;
  estimation::EstimationOptions locate;
  PickState state;
  hand::FakeHand hand;
  Executor robot;
};

TEST(MiddleOf, IsThatOfTheBestPoseOnceThereIsOne) {
  const geometry::KnownObject box = geometry::load_known_object("box");
  PickState state;
  state.place = {0.02, -0.03};
  EXPECT_EQ(middle_of(state, box), state.place);
  state.resting.emplace();
  EXPECT_EQ(middle_of(state, box), state.place) << "no pose explains the touches";
  localization::Mode mode;
  mode.T_frame_object.translation() << 0.05, 0.01, 0.04;
  state.resting->modes = {mode};
  const Eigen::Vector3d middle = mode.T_frame_object * box.mass_properties.centroid;
  EXPECT_TRUE(middle_of(state, box).isApprox(middle.head<2>()));
}

TEST(ExplorePhase, GoesOnTillAsManyHaveTouchedAsWereAskedFor) {
  Exploring exploring([](std::size_t sweep) { return sweep % 2 == 0; });
  exploring.options.touches = exploring.options.max_touches = 4;
  exploring.met = 0.02;  // even the moves that are shortened are longer
  exploring.explore();
  EXPECT_EQ(exploring.count_of(estimation::TouchEvent::touched), 4u);
  EXPECT_EQ(exploring.sweeps, 7u);
}

TEST(ExplorePhase, MakesNoMoreGuardedMovesThanItsTouchesNeed) {
  Exploring exploring([](std::size_t) { return true; });
  exploring.options.touches = exploring.options.max_touches = 4;
  exploring.explore();
  EXPECT_EQ(exploring.sweeps, 4u);
}

TEST(ExplorePhase, GivesUpWhereNothingIsSensed) {
  Exploring exploring([](std::size_t) { return false; });
  exploring.options.touches = exploring.options.max_touches = 4;
  EXPECT_EQ(exploring.explore().status, PhaseStatus::failed);
  EXPECT_EQ(exploring.sweeps, 8u);
  EXPECT_EQ(exploring.count_of(estimation::TouchEvent::missed), 8u);
}

TEST(ExplorePhase, IsSlowWhereTheObjectMayBe) {
  Exploring exploring([](std::size_t) { return false; });
  exploring.options.touches = exploring.options.max_touches = 2;
  exploring.options.radius = 0.25;  // far from the box
  exploring.explore();
  const auto& log = exploring.robot.log();
  const auto sets_out = log.all(estimation::TouchEvent::guarded_move);
  const auto misses = log.all(estimation::TouchEvent::missed);
  ASSERT_EQ(sets_out.size(), misses.size());
  for (std::size_t k = 0; k < misses.size(); ++k) {
    double fastest = 0, last = 0;  // m/s; in its second half
    for (std::size_t i = sets_out[k] + 1; i <= misses[k]; ++i) {
      const double speed =
          (log.readings[i].mount.xyz - log.readings[i - 1].mount.xyz).norm() / hand::kTick;
      fastest = std::max(fastest, speed);
      if (2 * i > sets_out[k] + misses[k]) last = std::max(last, speed);
    }
    const double touch_speed = 2 * exploring.options.touch_speed;  // of a heavy object
    EXPECT_GT(fastest, 2 * touch_speed);
    EXPECT_NEAR(last, touch_speed, 0.1 * touch_speed);
  }
}

/// What weighs no more than 0.1 kg is touched at the speed that is asked for.
TEST(ExplorePhase, TouchesLightObjectsSlowly) {
  geometry::KnownObject light = geometry::load_known_object("box");
  light.mass = 0.05;
  Exploring exploring([](std::size_t) { return false; }, light);
  exploring.options.touches = exploring.options.max_touches = 1;
  exploring.explore();
  const auto& log = exploring.robot.log();
  const std::size_t end = log.all(estimation::TouchEvent::missed).back();
  const Eigen::Vector3d way = log.readings[end - 10].mount.xyz - log.readings[end - 20].mount.xyz;
  EXPECT_NEAR(way.norm() / (10 * hand::kTick), exploring.options.touch_speed, 0.001);
}

/// Speed of the hand between two readings of a log, m/s; the fastest of them.
double fastest_between(const estimation::EventLog& log, std::size_t from, std::size_t to) {
  double fastest = 0;
  for (std::size_t i = from + 1; i <= to; ++i) {
    const Eigen::Vector3d way = log.readings[i].mount.xyz - log.readings[i - 1].mount.xyz;
    fastest = std::max(fastest, way.norm() / hand::kTick);
  }
  return fastest;
}

TEST(ExplorePhase, ComesDownSlowlyWhereTheObjectMayBe) {
  Exploring exploring([](std::size_t) { return false; });
  exploring.options.touches = exploring.options.max_touches = 2;
  exploring.options.radius = 0.1;  // a box that lies reaches 99 mm
  exploring.explore();
  const auto& log = exploring.robot.log();
  const auto sets_out = log.all(estimation::TouchEvent::guarded_move);
  const auto misses = log.all(estimation::TouchEvent::missed);
  ASSERT_EQ(sets_out.size(), misses.size());
  ASSERT_GE(sets_out.size(), 4u) << "a way down and a sweep, twice";
  std::size_t down = 0;
  for (std::size_t k = 0; k < misses.size(); ++k) {
    const auto& from = log.readings[sets_out[k]].mount.xyz;
    const auto& to = log.readings[misses[k]].mount.xyz;
    if ((from - to).head<2>().norm() > 1e-3) continue;
    ++down;
    EXPECT_GT(from.z() - to.z(), 0.02);
    EXPECT_LT(fastest_between(log, sets_out[k], misses[k]), 0.6 * exploring.options.speed);
  }
  EXPECT_EQ(2 * down, misses.size());
}

/// What is met where it was believed not to be is met no harder than by a guarded move.
TEST(ExplorePhase, BesideTheObjectNoFasterThanAGuardedMove) {
  Exploring exploring([](std::size_t) { return false; });
  exploring.options.touches = exploring.options.max_touches = 1;
  exploring.explore();
  const auto& readings = exploring.robot.log().readings;
  double way = 0, over = 0, beside = 0;  // m straight down in one go; m/s
  for (std::size_t i = 1; i < readings.size(); ++i) {
    const Eigen::Vector3d step = readings[i].mount.xyz - readings[i - 1].mount.xyz;
    const bool down = step.head<2>().norm() < 1e-9 && step.z() < 0;
    way = down ? way - step.z() : 0;
    double& fastest = way > 0.02 ? beside : over;  // m by which the hand travels above the box
    if (down) fastest = std::max(fastest, -step.z() / hand::kTick);
  }
  EXPECT_GT(over, 1.5 * exploring.options.speed);
  EXPECT_NEAR(beside, exploring.options.speed, 0.1 * exploring.options.speed);
}

TEST(ExplorePhase, WhatTheFingertipMeetsOnTheWayDownIsATouch) {
  Exploring exploring([](std::size_t) { return true; });
  exploring.met = 0.02;
  exploring.meets_on_the_way_down = true;
  exploring.options.touches = exploring.options.max_touches = 2;
  exploring.options.radius = 0.1;
  exploring.explore();
  EXPECT_EQ(exploring.sweeps, 0u);
  ASSERT_EQ(exploring.count_of(estimation::TouchEvent::touched), 2u);
  const auto& log = exploring.robot.log();
  for (std::size_t k = 0; k < 2; ++k) {
    const auto& from = log.readings[log.all(estimation::TouchEvent::guarded_move)[k]].mount.xyz;
    const auto& to = log.readings[log.all(estimation::TouchEvent::touched)[k]].mount.xyz;
    EXPECT_LT((from - to).head<2>().norm(), 1e-3);
  }
}

TEST(ExplorePhase, WhatIsMetOnAFastWayDownStopsItAndIsATouch) {
  Exploring exploring([](std::size_t) { return false; });
  exploring.roof = 0.02;
  exploring.options.touches = exploring.options.max_touches = 1;
  exploring.explore();
  ASSERT_EQ(exploring.count_of(estimation::TouchEvent::touched), 1u);
  const auto& readings = exploring.robot.log().readings;
  const auto met = std::find_if(readings.begin(), readings.end(),
                                [](const auto& reading) { return !reading.contacts[1].empty(); });
  const auto touched = exploring.robot.log().all(estimation::TouchEvent::touched).front();
  EXPECT_LT(met->mount.xyz.z() - readings[touched].mount.xyz.z(), 0.01);
}

TEST(ExplorePhase, AHardImpactEndsASweepBeforeItsLoadHasSettled) {
  Exploring exploring([](std::size_t) { return false; });
  exploring.blocks = [](std::size_t) { return true; };
  exploring.met = 0.015;  // 0.15 s after a sweep has set out
  exploring.obstacle = 25;
  exploring.options.touches = exploring.options.max_touches = 1;
  exploring.explore();
  const auto& log = exploring.robot.log();
  const auto from = log.all(estimation::TouchEvent::guarded_move).front();
  const auto to = log.all(estimation::TouchEvent::missed).front();
  EXPECT_LT((log.readings[to].mount.xyz - log.readings[from].mount.xyz).norm(), 0.025);
}

TEST(ExplorePhase, MakesUpForNoMissWhereMoreTouchesMayFollow) {
  Exploring exploring([](std::size_t) { return false; });
  exploring.options.touches = 4;
  exploring.options.max_touches = 8;
  exploring.explore();
  EXPECT_EQ(exploring.sweeps, 4u);  // without a pose there is none to distinguish
}

TEST(ExplorePhase, DistinguishesPosesByGuardedMovesNotMadeYet) {
  // The first touch leaves the box's yaw open; then something else is always in the way.
  Exploring exploring([](std::size_t sweep) { return sweep < 1; });
  exploring.blocks = [](std::size_t sweep) { return sweep >= 1; };
  exploring.options.touches = 2;
  exploring.options.max_touches = 10;
  exploring.explore();
  EXPECT_GT(exploring.sweeps, 5u);
  EXPECT_EQ(exploring.repeated(), 0u);
}

TEST(ExplorePhase, AGuardedMoveCutShortByTimeMissedNothing) {
  Exploring exploring([](std::size_t) { return false; });
  exploring.options.touches = exploring.options.max_touches = 2;
  exploring.options.speed = exploring.options.touch_speed = 0.0005;  // 185 s a guarded move
  EXPECT_EQ(exploring.explore().status, PhaseStatus::timed_out);
  EXPECT_GE(exploring.count_of(estimation::TouchEvent::guarded_move), 1u);
  EXPECT_EQ(exploring.count_of(estimation::TouchEvent::missed), 0u);
}

TEST(ExplorePhase, HasTimeForManyGuardedMoves) {
  const geometry::ObjectModel object(geometry::load_known_object("box"));
  estimation::PoseEstimator estimator(object, {}, 1);
  ExploreOptions options;
  EXPECT_EQ(ExplorePhase(estimator, options).time_limit(), 180);
  const double full = options.radius / options.speed;  // s to where the object is
  options.touches = options.max_touches = 64;
  EXPECT_GE(ExplorePhase(estimator, options).time_limit(), 2 * 64 * full);
}

/// A box at one of two places along x, and the finger that is to tell which, for each turn of the
/// hand; what it leads is blocked but in some turns.
struct TwoPlaces {
  explicit TwoPlaces(const std::vector<std::size_t>& free, double doubt = 0.5) {
    for (const double x : {0.0, 0.02}) {
      localization::Mode mode;
      mode.T_frame_object.translation().x() = x;
      mode.weight = x > 0 ? doubt : 1 - doubt;
      posterior.modes.push_back(mode);
    }
    for (std::size_t turn = 0; turn < kTurns.size(); ++turn) {
      localization::ProbingFinger finger{{{Eigen::Vector3d::Zero(), 0.007}}, {}};
      finger.seconds = turn < 2 ? 1 : 0.5;
      if (std::ranges::find(free, turn) == free.end()) {
        finger.rest.push_back({Eigen::Vector3d::Zero(), 0.02});
      }
      fingers.push_back(finger);
    }
    untried.fill({{{0, 0.2, 0}, {0, -0.2, 0}}, {{0.2, 0, 0}, {-0.2, 0, 0}}});
  }
  std::optional<localization::TurnedMove> take() {
    return take_most_informative({{&object, posterior}}, fingers, untried);
  }

  geometry::ObjectModel object{geometry::load_known_object("box")};
  localization::Posterior posterior;
  std::vector<localization::ProbingFinger> fingers;
  UntriedMoves untried;
};

TEST(TakeMostInformative, IsMadeOnce) {
  TwoPlaces places({0, 1, 2, 3});
  const auto move = places.take();
  ASSERT_TRUE(move);
  EXPECT_EQ(move->turn, 1u);
  EXPECT_EQ(move->guarded_move.from, Eigen::Vector3d(0.2, 0, 0));
  ASSERT_EQ(places.untried[1].size(), 1u);
  EXPECT_EQ(places.untried[1][0].from, Eigen::Vector3d(0, 0.2, 0));
  EXPECT_EQ(places.take()->turn, 0u) << "what is left of that turn tells nothing";
}

TEST(TakeMostInformative, TheHandIsTurnedByAQuarterOnlyWhereOtherTurnsAreLessInformative) {
  EXPECT_EQ(TwoPlaces({0, 2, 3}).take()->turn, 0u) << "though a quarter takes less time";
  EXPECT_EQ(TwoPlaces({0, 2, 3}, 0.05).take()->turn, 2u) << "0.095 are left";
  EXPECT_EQ(TwoPlaces({3}).take()->turn, 3u);
  EXPECT_FALSE(TwoPlaces({}).take());
}

}  // namespace
}  // namespace palpate::skills
