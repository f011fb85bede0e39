// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/demonstration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/mjcf_hand.hpp"
#include "palpate/tasks/relocate/synthetic_human.hpp"

namespace palpate::relocate {
namespace {

RelocateModel fast_model() {
  TaskOptions options;
  options.solver = "fast";
  return make_model(options);
}

TEST(SyntheticHuman, TheTipsTouchTheObjectAndTheWristMovesSmoothly) {
  SyntheticHumanOptions options;
  options.noise = options.missing = options.place_spread = 0;
  RandomStream random(2);
  const Eigen::Vector3d object(-0.06, 0.02, 0.035), target(0.05, -0.1, 0.2);
  const auto grasp = synthetic_grasp(object, {}, options, random).keypoints();
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    const Eigen::Vector3d tip =
        grasp.col(learning::keypoint(static_cast<hand::FingerName>(finger), 3));
    const double off = (tip - object).head<2>().norm() - options.grip_radius;
    EXPECT_GT(off, -0.003) << finger;
    EXPECT_LT(off, 0.025) << finger;
  }
  const auto sequence = synthetic_relocation(object, target, options, random);
  ASSERT_EQ(sequence.hand.size(), sequence.T_hand_object.size());
  EXPECT_LT((sequence.T_hand_object.front().translation() - object).norm(), 1e-9);
  EXPECT_LT((sequence.T_hand_object.back().translation() - target).norm(), 1e-9);
  for (std::size_t i = 1; i < sequence.hand.size(); ++i) {
    // 3 m/s is as fast as people reach.
    EXPECT_LT((sequence.hand[i].col(0) - sequence.hand[i - 1].col(0)).norm() * options.rate, 3);
  }
}

TEST(Demonstration, TheRobotRepeatsWhatAHumanShows) {
  const auto model = fast_model();
  const auto set = make_demonstrations(model, {}, 3, 3, 16, 2);
  ASSERT_EQ(set.kept.size(), 3U);
  for (const auto& d : set.kept) {
    EXPECT_LT(d.episode.distance, 0.05);
    EXPECT_FALSE(d.episode.diverged);
    EXPECT_GT(d.episode.total, 1000);
    EXPECT_LE(d.path.actions.cwiseAbs().maxCoeff(), 1);
  }
  const auto again = make_demonstrations(model, {}, 3, 3, 16, 1);
  ASSERT_EQ(again.kept.size(), 3U);
  EXPECT_EQ(again.kept[1].path.actions, set.kept[1].path.actions);
  const auto frames = frames_of(set.kept);
  EXPECT_EQ(frames.actions.cols(), frames.observations.cols());
  EXPECT_NO_THROW(check(frames));
}

TEST(Demonstration, NoiseMovesTheRobotButIsNotInWhatIsTaught) {
  const auto model = fast_model();
  DemonstrationOptions options;
  const double height = rest_height(model);
  const auto quiet = synthetic_demonstration(model, options, height, 3, 0);
  EXPECT_EQ(quiet.intended, quiet.path.actions);
  options.translation.noise = 0.05;
  options.translation.noise_time = 0.05;
  const auto noisy = synthetic_demonstration(model, options, height, 3, 0);
  ASSERT_EQ(noisy.intended.cols(), noisy.path.actions.cols());
  // The same human; the first frame is met before any noise has acted.
  EXPECT_EQ(noisy.intended.col(0), quiet.intended.col(0));
  EXPECT_NE(noisy.path.observations.col(9), quiet.path.observations.col(9));
  // Actions at a limit of -1..1 show less of the noise, hence the wide band below 0.05.
  const Eigen::MatrixXd added = noisy.path.actions - noisy.intended;
  const double spread = std::sqrt(added.squaredNorm() / static_cast<double>(added.size()));
  EXPECT_GT(spread, 0.03);
  EXPECT_LT(spread, 0.06);
  EXPECT_LE(noisy.path.actions.cwiseAbs().maxCoeff(), 1);
  EXPECT_EQ(frames_of(std::vector<Demonstration>{noisy}).actions, noisy.intended);
}

TEST(Demonstration, NothingIsKeptThatFails) {
  DemonstrationOptions options;
  options.translation.press = 0;  // nobody lifts a mug without touching it
  options.human.grip_radius = 0.06;
  const auto set = make_demonstrations(fast_model(), options, 3, 2, 2, 1);
  EXPECT_EQ(set.kept.size(), 0U);
  EXPECT_EQ(set.tried, 2U);
}

TEST(Demonstration, RefusesASequenceWithoutObject) {
  const auto model = fast_model();
  RandomStream random(5);
  auto sequence = synthetic_relocation({-0.06, 0, 0.035}, {0, 0, 0.2}, {}, random);
  sequence.T_hand_object.pop_back();
  learning::Retargeter retargeter(
      std::make_unique<simulation::MjcfHand>(asset("adroit_hand/adroit_relocate.xml"), "palm"),
      learning::adroit_points());
  RelocateDynamics dynamics(model);
  EXPECT_THROW(translate(sequence, retargeter, dynamics, {}), BadInput);
}

}  // namespace
}  // namespace palpate::relocate
