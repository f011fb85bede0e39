// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/in_hand_phase.hpp"

#include <gtest/gtest.h>

#include "evaluation/quick_options.hpp"
#include "palpate/core/random.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/simulation/collision/forward_model.hpp"
#include "palpate/skills/place/place.hpp"

namespace palpate::skills {
namespace {

double angle_between(const hand::MountPosition& a, const hand::MountPosition& b) {
  return rotation_distance(a.pose().linear(), b.pose().linear());
}

HeldObject some_hold(RandomStream& random) {
  HeldObject held;
  held.T_mount_object.linear() = exp_so3(random.normal3());
  held.T_mount_object.translation() = 0.1 * random.normal3();
  held.T_mount_object_flat = held.T_mount_object;
  return held;
}

TEST(InHandReorientation, TakesItsShareOffTheTurnOfTheMount) {
  RandomStream random(1, "share");
  for (int i = 0; i < 100; ++i) {
    const hand::MountPosition now{random.normal3(), 0.5 * random.normal3()};
    const HeldObject held = some_hold(random);
    const hand::MountPosition wanted{random.normal3(), 0.5 * random.normal3()};
    const Eigen::Isometry3d target = wanted.pose() * held.T_mount_object;
    const double most = random.uniform(0.05, 0.4);
    const Eigen::Vector3d asked = share_of_fingers(now, wanted, most);
    EXPECT_NEAR(asked.norm(), std::min(most, angle_between(now, wanted)), 1e-9);
    // Held as it is then, the object comes to the target with that much less of a turn.
    const HeldObject turned = turned_in_hand(held, now, asked);
    const Eigen::Matrix3d R = (target * turned.T_mount_object.inverse()).linear();
    EXPECT_NEAR(rotation_distance(R, now.pose().linear()),
                angle_between(now, wanted) - asked.norm(), 1e-6);
    EXPECT_EQ(turned.T_mount_object.translation(), held.T_mount_object.translation());
    // It has turned by that in the world.
    const Eigen::Matrix3d before = now.pose().linear() * held.T_mount_object.linear();
    const Eigen::Matrix3d after = now.pose().linear() * turned.T_mount_object.linear();
    EXPECT_NEAR((log_so3(after * before.transpose()) - asked).norm(), 0, 1e-9);
  }
}

TEST(InHandReorientation, FindsTheShorterOfTheTurnsThatReach) {
  RandomStream random(2, "reach");
  const HeldObject held = some_hold(random);
  const hand::MountPosition mount{{0, 0, 0.3}, {0.3, -0.2, 0.1}};
  const auto angle_of = [&](const HeldObject& other) {
    return rotation_distance(other.T_mount_object.linear(), held.T_mount_object.linear());
  };
  const auto from = [&](double least) {
    return turn_that_reaches(held, mount, {0, 0, 0}, 0.3,
                             [&](const HeldObject& other) { return angle_of(other) > least; });
  };
  EXPECT_NEAR(from(0.1)->norm(), 0.15, 1e-9);
  EXPECT_NEAR(from(0.2)->norm(), 0.3, 1e-9);
  EXPECT_FALSE(from(0.31));
  // Towards the target before anything else.
  const Eigen::Vector3d towards(0.2, 0.1, -0.1);
  const auto any = turn_that_reaches(held, mount, towards, 0.3, [](const auto&) { return true; });
  EXPECT_NEAR((*any - 0.15 * towards.normalized()).norm(), 0, 1e-9);
}

TEST(InHandReorientation, HasTheTimeThatItMayTake) {
  const geometry::ObjectModel object(geometry::load_known_object("box"));
  InHandReorientation turn;
  InHandReorientationOptions options;
  for (const double longest : {0.1, 16.0, 600.0}) {
    options.reorient.longest = longest;
    options.settle = 2;
    const double limit = InHandReorientationPhase(options, object, 1, turn).time_limit();
    EXPECT_GT(limit, longest + options.settle + 5);
    EXPECT_LT(limit, longest + options.settle + 20);
  }
}

/// A box that hangs in the hand after a quick pick, to be placed with the fingers' help.
struct HeldBox {
  static constexpr std::uint64_t kSeed = 7;

  HeldBox() : object(geometry::load_known_object("box")), world(object.object(), {}, kSeed) {
    options.pick.calibrate = {};
    options.place.strategy = "fingers";
    options.place.fingers.reorient.sampling.samples = 4;
    world.reset(evaluation::draw_start(object.object(), options.start, kSeed),
                evaluation::waiting_command(world.hand_model()));
    robot.emplace(world.hand(), world.hand_model(), evaluation::waiting_command(world.hand_model()),
                  Executor::Observer{}, &models);
    picked = pick(*robot, object, options.pick, kSeed);
  }
  PlaceResult place_it() {
    const auto target = evaluation::place_target(object.object(), options.place, kSeed, 0);
    return place(*robot, {object, *target, {}, options.pick, options.place, kSeed}, picked);
  }

  evaluation::TrialOptions options = evaluation::quick_place_options();
  geometry::ObjectModel object;
  simulation::World world;
  simulation::SimulatedModels models;
  std::optional<Executor> robot;
  PickResult picked;
};

TEST(InHandReorientation, APoseThatDriftsEndsWithTheObjectPutBack) {
  HeldBox scene;
  ASSERT_TRUE(scene.picked.held);
  scene.options.place.fingers.reorient.drift_angle = 0.001;  // nothing is known so well
  const auto placed = scene.place_it();
  ASSERT_TRUE(placed.reorientation);
  EXPECT_EQ(placed.reorientation->result.end, ReorientEnd::drift);
  EXPECT_FALSE(placed.reorientation->known);
  EXPECT_EQ(placed.status, PlaceStatus::slipped);
  EXPECT_EQ(placed.failed_phase, "turn");
  EXPECT_EQ(placed.phases.back().name, "withdraw");
  // It stands: nothing fell or was thrown.
  scene.robot->wait(0.5);
  const Eigen::Isometry3d truth = scene.world.truth().T_world_object;
  EXPECT_LT(nearest_stable_pose(scene.object.object(), truth.linear()).tilt, 0.05);
  EXPECT_LT(scene.world.truth().lowest_point, 0.002);
}

TEST(InHandReorientation, WhereFingersLetGoTheMountTakesWhatIsLeft) {
  HeldBox scene;
  ASSERT_TRUE(scene.picked.held);
  scene.options.place.fingers.reorient.longest = 0.1;  // one step, and no more
  const auto placed = scene.place_it();
  ASSERT_TRUE(placed.reorientation);
  EXPECT_EQ(placed.reorientation->result.end, ReorientEnd::out_of_time);
  EXPECT_GT(placed.reorientation->result.left.rotation, 0.1);
  EXPECT_EQ(placed.status, PlaceStatus::placed) << placed.phases.back().outcome;
  EXPECT_LT(scene.world.truth().lowest_point, 0.002);
}

double pressing(const Executor& robot) {
  double sum = 0;
  for (int finger = 0; finger < hand::kShadowFingers; ++finger)
    sum += hand::tip_force(robot.reading(), finger);
  return sum;
}

TEST(InHandReorientation, FingersThatAreAboutToLetGoPressAgain) {
  HeldBox scene;
  ASSERT_TRUE(scene.picked.held);
  InHandReorientationOptions options = scene.options.place.fingers;
  options.reorient.min_fingers = hand::kShadowFingers + 1;  // more than there are
  options.reorient.errors = scene.options.pick.estimation.errors;
  PickState state;
  state.estimate = scene.picked.estimate;
  InHandReorientation turn;
  turn.asked = {0, 0, 0.1};
  const double before = pressing(*scene.robot);
  const PhaseEnd end = InHandReorientationPhase(options, scene.object, HeldBox::kSeed, turn)
                           .run(*scene.robot, state);
  EXPECT_EQ(turn.result.end, ReorientEnd::losing);
  EXPECT_EQ(turn.result.steps, 0);
  EXPECT_GT(pressing(*scene.robot), 1.2 * before);
  EXPECT_FALSE(turn.lost);
  EXPECT_FALSE(turn.known);  // nothing has followed what pressing did
  EXPECT_FALSE(end.ok);
  EXPECT_GT(scene.world.truth().lowest_point, 0.02);  // it hangs
}

}  // namespace
}  // namespace palpate::skills
