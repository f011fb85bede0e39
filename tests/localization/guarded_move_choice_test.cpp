// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/information/guarded_move_choice.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "localization/mode_at.hpp"

namespace palpate::localization {
namespace {

const geometry::ObjectModel& box() {
  static const geometry::ObjectModel model(geometry::load_known_object("box"));
  return model;
}

const ProbingFinger kBall = {{{Eigen::Vector3d::Zero(), 0.007}}, {}};
const GuardedMove kAlongX = {{0.2, 0, 0}, {-0.2, 0, 0}};
const GuardedMove kAlongY = {{0, 0.2, 0}, {0, -0.2, 0}};

TEST(MostInformativeMove, IsAcrossTheDirectionInWhichTheModesDiffer) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 0.5), mode_at({0.02, 0, 0}, 0.5)};
  const auto best = most_informative_move(box(), posterior, kBall, {kAlongY, kAlongX});
  ASSERT_TRUE(best);
  EXPECT_EQ(best->guarded_move.from, kAlongX.from);
  EXPECT_EQ(best->index, 1u);
  EXPECT_NEAR(best->information, 0.5, 1e-9);  // two equal modes that are surely distinguished
  EXPECT_EQ(best->rate, best->information);
  ProbingFinger slow = kBall;
  slow.seconds = 4;
  EXPECT_NEAR(most_informative_move(box(), posterior, slow, {kAlongX})->rate, 0.125, 1e-9);
}

TEST(MostInformativeMove, WhereTheFingerGrazesChanceDecides) {
  double half = 0;
  for (const auto& vertex : box().object().mesh.vertices) half = std::max(half, vertex.y());
  const double beside = half + kBall.tip[0].radius;
  const auto informative = [&](double between, double aside) {
    localization::Posterior posterior;
    posterior.modes = {mode_at({0, 0, 0}, 0.5), mode_at({0, between, 0}, 0.5)};
    const Eigen::Vector3d shift(0, aside, 0);
    const auto move = most_informative_move(box(), posterior, kBall,
                                            {{kAlongX.from + shift, kAlongX.to + shift}});
    return move ? move->information : 0;
  };
  EXPECT_NEAR(informative(0.020, beside + 0.010), 0.5, 1e-9);
  EXPECT_LT(informative(0.002, beside + 0.001), 0.25) << "no more sure than a coin";
}

TEST(MostInformativeMove, UnlikelyModesAreWorthLess) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 0.95), mode_at({0.02, 0, 0}, 0.05)};
  const auto best = most_informative_move(box(), posterior, kBall, {kAlongX});
  ASSERT_TRUE(best);
  EXPECT_NEAR(best->information, 2 * 0.95 * 0.05, 1e-9);
}

TEST(MostInformativeMove, AFreeAxisLeavesSomethingToTell) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 1)};
  posterior.modes[0].free_axis = {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 1.5};
  EXPECT_TRUE(most_informative_move(box(), posterior, kBall, {kAlongX}));
}

TEST(MostInformativeMove, OneModeLeavesNothingToTell) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 1)};
  EXPECT_FALSE(most_informative_move(box(), posterior, kBall, {kAlongX, kAlongY}));
  EXPECT_FALSE(most_informative_move(box(), posterior, kBall, {}));
}

TEST(MostInformativeMove, BlockedByAnotherPartOfTheHandHasNoInformation) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 0.5), mode_at({0.02, 0, 0}, 0.5)};
  ProbingFinger blocked = kBall;
  blocked.rest.push_back({{0, 0, 0}, 0.02});
  EXPECT_FALSE(most_informative_move(box(), posterior, blocked, {kAlongX}));
}

/// m along x until the ball meets the box.
double way_to_box() {
  double half = 0;
  for (const auto& vertex : box().object().mesh.vertices) half = std::max(half, vertex.x());
  return kAlongX.from.x() - half - kBall.tip[0].radius;
}

TEST(ClearWay, EndsWhereTheNearestCrediblePoseIsTouched) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 0.6), mode_at({0.02, 0, 0}, 0.4)};
  EXPECT_NEAR(clear_way({{&box(), posterior}}, kBall, kAlongX), way_to_box() - 0.02, 0.004);
}

TEST(ClearWay, DoesNotReckonWithPosesThatTogetherAreUnlikely) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 0.99), mode_at({0.05, 0, 0}, 0.01)};
  const std::vector<PosedObject> objects = {{&box(), posterior}};
  EXPECT_NEAR(clear_way(objects, kBall, kAlongX), way_to_box(), 0.004);
  EXPECT_NEAR(clear_way(objects, kBall, kAlongX, 0.005), way_to_box() - 0.05, 0.004);
}

TEST(ClearWay, IsNoneWhereThePosesAreFarFromAll) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 0.5), mode_at({0.02, 0, 0}, 0.4)};
  EXPECT_EQ(clear_way({{&box(), posterior}}, kBall, kAlongX), 0);
  EXPECT_GT(clear_way({{&box(), posterior}}, kBall, kAlongX, 0.11), 0.05);
}

/// The way of a guarded move until a ball is in the box at some place, looked at every 3 mm.
double way_by_every_place(const Eigen::Isometry3d& T_box_world, const ProbingFinger& finger,
                          const GuardedMove& move) {
  const geometry::DistanceField& field = box().field();
  const double length = (move.to - move.from).norm();
  const auto meets = [&](const FreeSphere& ball, const Eigen::Vector3d& at, double margin) {
    const double distance = field.distance((T_box_world * (at + ball.center)).cast<float>());
    return distance < field.beyond() && distance < ball.radius + margin;
  };
  for (double way = 0; way <= length; way += 0.003) {
    const Eigen::Vector3d at = move.from + way / length * (move.to - move.from);
    for (const auto& ball : finger.rest) {
      if (meets(ball, at, 0.002)) return way;
    }
    for (const auto& ball : finger.tip) {
      if (meets(ball, at, 0)) return way;
    }
  }
  return length;
}

/// Places that are passed over are places where no ball meets the object.
TEST(ClearWay, IsThatOfEveryPlace) {
  ProbingFinger hand = kBall;
  hand.rest = {{{0, 0, 0.03}, 0.01}, {{0.04, 0.01, 0.08}, 0.03}, {{-0.05, 0, 0.1}, 0.05}};
  RandomStream random(3);
  int met = 0;
  for (int i = 0; i < 300; ++i) {
    localization::Posterior posterior;
    posterior.modes = {mode_at(0.05 * random.normal3(), 1)};
    Eigen::Isometry3d& T = posterior.modes[0].T_frame_object;
    T.linear() = random.rotation();
    const GuardedMove move = {0.2 * random.unit_vector(), 0.2 * random.unit_vector()};
    const double way = way_by_every_place(T.inverse(), hand, move);
    EXPECT_EQ(clear_way({{&box(), posterior}}, hand, move), way) << i;
    met += way > 0.01 && way < (move.to - move.from).norm() - 0.01;
  }
  EXPECT_GT(met, 50);
}

TEST(ClearWay, IsAllOfAWayThatMeetsNothing) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0.3, 0}, 1)};
  EXPECT_NEAR(clear_way({{&box(), posterior}}, kBall, kAlongX), 0.4, 1e-9);
}

TEST(UsefulWay, EndsWhereTheFarthestCrediblePoseIsTouched) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0.02, 0, 0}, 0.6), mode_at({0, 0, 0}, 0.3),
                     mode_at({0, 0.3, 0}, 0.1)};
  EXPECT_NEAR(useful_way({{&box(), posterior}}, kBall, kAlongX), way_to_box(), 0.004)
      << "a pose that is missed in any case makes it no longer";
}

TEST(UsefulWay, IsAllOfAWayThatMeetsNothingOrWhereTheObjectMayBeElsewhere) {
  for (const localization::Mode& mode : {mode_at({0, 0.3, 0}, 1), mode_at({0, 0, 0}, 0.9)}) {
    localization::Posterior posterior;
    posterior.modes = {mode};
    EXPECT_NEAR(useful_way({{&box(), posterior}}, kBall, kAlongX), 0.4, 1e-9) << mode.weight;
  }
}

ProbingFinger turned_ball(double yaw) {
  ProbingFinger finger = kBall;
  finger.R_world_mount = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return finger;
}

TEST(MostRefiningGuardedMove, GoesWhereThePlaceIsNotKnown) {
  const std::vector<GuardedMove> guarded_moves = {kAlongX, kAlongY};
  const std::vector<TurnedMove> done = {{kAlongX, 0}, {kAlongX, 0}};
  const auto best = most_refining_move(box(), Eigen::Isometry3d::Identity(), {turned_ball(0)},
                                       guarded_moves, done);
  ASSERT_TRUE(best);
  EXPECT_EQ(best->guarded_move.guarded_move.from, kAlongY.from);
  EXPECT_LT(best->after, best->before);
}

TEST(MostRefiningGuardedMove, TurnsTheHandToTellItsOffsetFromThePlace) {
  const std::vector<ProbingFinger> fingers = {turned_ball(0), turned_ball(M_PI)};
  const std::vector<TurnedMove> done(6, {kAlongX, 0});
  const auto best =
      most_refining_move(box(), Eigen::Isometry3d::Identity(), fingers, {kAlongX}, done);
  ASSERT_TRUE(best);
  EXPECT_EQ(best->guarded_move.turn, 1U);
}

TEST(MostRefiningGuardedMove, DoesNotTurnTheHandWhereThatTakesTooLong) {
  std::vector<ProbingFinger> fingers = {turned_ball(0), turned_ball(M_PI)};
  const std::vector<TurnedMove> done(6, {kAlongX, 0});
  fingers[1].seconds = 1000;
  const auto best =
      most_refining_move(box(), Eigen::Isometry3d::Identity(), fingers, {kAlongX}, done);
  ASSERT_TRUE(best);
  EXPECT_EQ(best->guarded_move.turn, 0U);
  const auto worthwhile = most_refining_move(box(), Eigen::Isometry3d::Identity(), fingers,
                                             {kAlongX}, done, (best->after - 0.1) / best->before);
  ASSERT_TRUE(worthwhile) << "the other one leaves less";
  EXPECT_EQ(worthwhile->guarded_move.turn, 1U);
}

TEST(MostRefiningGuardedMove, NeedsATouch) {
  const GuardedMove beside = {{0.3, 0.3, 0}, {0.2, 0.3, 0}};
  EXPECT_FALSE(
      most_refining_move(box(), Eigen::Isometry3d::Identity(), {turned_ball(0)}, {beside}, {}));
}

}  // namespace
}  // namespace palpate::localization
