// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/reorient/in_hand_reorientation.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/collision/forward_model.hpp"

namespace palpate::skills {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr double kFriction = 0.8;  // of the world, which the forward model knows

/// A bracket that hangs in the hand after a pick.
struct HeldBracket {
  explicit HeldBracket(const simulation::WorldOptions& world_options = {})
      : world(object.object(), world_options, kSeed) {
    evaluation::TrialOptions options = evaluation::TrialOptions::ideal();
    world.reset(evaluation::draw_start(object.object(), options.start, kSeed),
                evaluation::waiting_command(world.hand_model()));
    robot.emplace(world.hand(), world.hand_model(), evaluation::waiting_command(world.hand_model()),
                  Executor::Observer{}, &models);
    picked = pick(*robot, object, options.pick, kSeed);
  }
  Eigen::Isometry3d truth() const { return world.truth().T_world_object; }

  geometry::ObjectModel object{geometry::load_known_object("bracket")};
  simulation::World world;
  simulation::SimulatedModels models{{.hand_friction = kFriction}};
  std::optional<Executor> robot;
  PickResult picked;
};

Eigen::Isometry3d turned(Eigen::Isometry3d T, const Eigen::Vector3d& rotation) {
  T.linear() = exp_so3(rotation) * T.linear();
  return T;
}

TEST(SimulatedForwardModel, HoldsWhatTheHandHoldsAndDropsWhatItLetsGo) {
  simulation::WorldOptions
      exact;  // else the believed hand would hold what the true one holds badly
  exact.noise = {0, 0, 0, 0, 0, 0};
  HeldBracket scene(exact);
  ASSERT_TRUE(scene.picked.held);
  simulation::SimulatedForwardModel model(scene.object.object(), scene.world.hand_model(),
                                          {.hand_friction = kFriction});
  EXPECT_THROW((void)model.rollout({}), BadInput);
  BelievedGrasp grasp{scene.robot->command(), scene.robot->reading().joints, scene.truth()};
  const auto settled = model.settle(grasp, 0.1);
  EXPECT_FALSE(settled.diverged);
  EXPECT_GT(settled.tip_forces[0], 0.1);

  const std::vector<hand::HandCommand> hold(30, grasp.command);
  const auto held = model.rollout(hold);
  EXPECT_LT((held.T_mount_object.translation() - settled.T_mount_object.translation()).norm(),
            0.001);

  std::vector<hand::HandCommand> open = hold;
  for (auto& command : open) command.positions.tail<hand::kShadowActuators - 2>().setZero();
  const auto dropped = model.rollout(open);
  EXPECT_GT((dropped.T_mount_object.translation() - settled.T_mount_object.translation()).norm(),
            0.03);
  const auto again = model.rollout(hold);
  EXPECT_EQ(again.T_mount_object.matrix(), held.T_mount_object.matrix());

  grasp.joints[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)model.settle(grasp, 0.1), BadInput);
}

TEST(SimulatedForwardModel, HasTheOptionsThatItIsGiven) {
  simulation::WorldOptions exact;
  exact.noise = {0, 0, 0, 0, 0, 0};
  HeldBracket scene(exact);
  ASSERT_TRUE(scene.picked.held);
  const BelievedGrasp grasp{scene.robot->command(), scene.robot->reading().joints, scene.truth()};
  const auto settled = [&](const simulation::ForwardModelOptions& options) {
    return simulation::SimulatedForwardModel(scene.object.object(), scene.world.hand_model(),
                                             options)
        .settle(grasp, 0.1);
  };
  const simulation::ForwardModelOptions known{.hand_friction = kFriction};
  const auto usual = settled(known);
  const auto differs = [&](const simulation::ForwardModelOptions& options) {
    return (settled(options).T_mount_object.matrix() - usual.T_mount_object.matrix()).norm();
  };
  EXPECT_EQ(differs(known), 0);
  EXPECT_GT(usual.tip_forces[0], 0.1);
  EXPECT_GT(differs({.hand_friction = 0.02}), 0.01);  // it falls
  EXPECT_GT(differs({.time_step = 0.005, .hand_friction = kFriction}), 0);
  EXPECT_GT(differs({.hand_friction = kFriction, .exact_tips = false}), 0);
  EXPECT_LT(settled({.hand_friction = kFriction, .stiffness_scale = 1}).tip_forces[0],
            0.9 * usual.tip_forces[0]);
  EXPECT_THROW((void)settled({.time_step = 0.003}), BadInput);
}

const Eigen::Vector3d kTurn(0, 0, 0.17);  // rad

/// The estimated pose turned, and the true one.
std::pair<Eigen::Isometry3d, Eigen::Isometry3d> goals(const HeldBracket& scene,
                                                      const Eigen::Vector3d& turn) {
  return {turned(scene.picked.estimate.posterior.modes.front().T_frame_object, turn),
          turned(scene.truth(), turn)};
}

TEST(ReorientInHand, TurnsABracketAndSaysHowFar) {
  HeldBracket scene;
  ASSERT_TRUE(scene.picked.held);
  const auto& posterior = scene.picked.estimate.posterior;
  const auto [goal, true_goal] = goals(scene, kTurn);
  ReorientOptions options;
  options.sampling.samples = 8;
  const auto result = reorient_in_hand(*scene.robot, scene.object, posterior, goal, options, kSeed);
  EXPECT_EQ(result.end, ReorientEnd::reached);
  EXPECT_LT(result.left.rotation, options.done_angle);
  const auto error =
      localization::pose_error(scene.truth(), true_goal, {Eigen::Matrix3d::Identity()});
  EXPECT_LT(error.rotation, 0.1);
  EXPECT_LT(error.translation, 0.01);
  EXPECT_GT(result.rollouts, 0);
}

TEST(ReorientInHand, ChoosesTheSameStepsWithTwoThreads) {
  std::array<ReorientResult, 2> results;
  for (int threads : {1, 2}) {
    HeldBracket scene;
    ASSERT_TRUE(scene.picked.held);
    const auto& posterior = scene.picked.estimate.posterior;
    ReorientOptions options;
    options.longest = 1.5;
    options.tightenings = 1;
    options.sampling.samples = 4;
    const Eigen::Isometry3d goal =
        turned(posterior.modes.front().T_frame_object, Eigen::Vector3d(0, 0.1, 0));
    results[static_cast<std::size_t>(threads - 1)] =
        reorient_in_hand(*scene.robot, scene.object, posterior, goal, options, kSeed, threads);
  }
  EXPECT_GT(results[0].rollouts, 0);
  EXPECT_EQ(results[0].steps, results[1].steps);
  EXPECT_EQ(results[0].posterior.modes.front().T_frame_object.matrix(),
            results[1].posterior.modes.front().T_frame_object.matrix());
}

TEST(ReorientInHand, NeedsNoRolloutsToGoOnHolding) {
  HeldBracket scene;
  ASSERT_TRUE(scene.picked.held);
  const auto& posterior = scene.picked.estimate.posterior;
  const auto [goal, true_goal] = goals(scene, kTurn);
  ReorientOptions options;
  options.sampling.samples = 0;
  options.longest = 3;
  const auto result = reorient_in_hand(*scene.robot, scene.object, posterior, goal, options, kSeed);
  EXPECT_EQ(result.rollouts, 0);
  EXPECT_GT(result.steps, options.tightenings);
  const auto error =
      localization::pose_error(scene.truth(), true_goal, {Eigen::Matrix3d::Identity()});
  // Carried along alone few objects come near (3 of 27); none may be turned away.
  EXPECT_LT(error.rotation, kTurn.norm() + 0.02);
  EXPECT_GT(scene.world.truth().lowest_point, 0.02);  // it hangs

  // Where the time for all of it ends, no step is planned for a motion that nobody makes.
  options.longest = 100;
  options.patience = 1000;
  scene.robot->set_deadline(scene.robot->time() + options.pause + 0.2);
  const auto late = reorient_in_hand(*scene.robot, scene.object, result.posterior,
                                     turned(goal, -2 * kTurn), options, kSeed);
  EXPECT_EQ(late.end, ReorientEnd::out_of_time);
  EXPECT_EQ(late.steps, 1);
  EXPECT_LT(late.seconds, options.pause + 0.25);
}

TEST(ReorientInHand, EndsWhereItComesNoNearer) {
  HeldBracket scene;
  ASSERT_TRUE(scene.picked.held);
  const auto& posterior = scene.picked.estimate.posterior;
  const Eigen::Isometry3d goal =
      turned(posterior.modes.front().T_frame_object, Eigen::Vector3d(0, 0, 0.17));
  ReorientOptions options;
  options.sampling.samples = 0;
  options.speed = 0.001;  // less than can be measured
  options.linear_speed = 1e-4;
  options.patience = 1;
  const auto result = reorient_in_hand(*scene.robot, scene.object, posterior, goal, options, kSeed);
  EXPECT_EQ(result.end, ReorientEnd::out_of_time);
  EXPECT_LT(result.seconds, options.longest);
}

TEST(ReorientInHand, RejectsAGoalThatIsNoneAndAMissingPose) {
  HeldBracket scene;
  Eigen::Isometry3d goal = Eigen::Isometry3d::Identity();
  EXPECT_THROW((void)reorient_in_hand(*scene.robot, scene.object, {}, goal, {}, kSeed), BadInput);
  goal.translation().x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW((void)reorient_in_hand(*scene.robot, scene.object, scene.picked.estimate.posterior,
                                      goal, {}, kSeed),
               BadInput);
}

}  // namespace
}  // namespace palpate::skills
