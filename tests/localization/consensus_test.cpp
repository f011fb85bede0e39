// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/consensus.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace palpate::localization {
namespace {

const std::vector<Eigen::Matrix3d> kNone = {Eigen::Matrix3d::Identity()};

Eigen::Isometry3d pose(double yaw, double x) {
  return Eigen::Translation3d(x, 0, 0) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::Isometry3d::Identity();
}

TEST(Consensus, OfNothingIsNothing) { EXPECT_EQ(consensus({}, kNone, {}).share, 0); }

TEST(Consensus, IsTheMeanOfWhatAgrees) {
  const auto result = consensus(
      {{pose(0.00, 0.000), 0.3}, {pose(0.04, 0.004), 0.3}, {pose(1.0, 0.0), 0.4}}, kNone, {});
  EXPECT_NEAR(result.share, 0.6, 1e-12);
  EXPECT_LT((result.T.matrix() - pose(0.02, 0.002).matrix()).norm(), 1e-6);
}

TEST(Consensus, PosesThatDifferByASymmetryAgree) {
  const std::vector<Eigen::Matrix3d> half = {
      Eigen::Matrix3d::Identity(),
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()).toRotationMatrix()};
  const std::vector<WeightedPose> poses = {{pose(0, 0), 0.5}, {pose(std::numbers::pi, 0), 0.5}};
  EXPECT_NEAR(consensus(poses, half, {}).share, 1, 1e-12);
  EXPECT_NEAR(consensus(poses, kNone, {}).share, 0.5, 1e-12);
}

TEST(Entropy, IsThatOfTheWeights) {
  EXPECT_EQ(entropy({}, {0, 0}), 0);
  EXPECT_EQ(entropy({{pose(0, 0), 0.3}}, {0, 0}), 0);
  EXPECT_NEAR(entropy({{pose(0, 0), 0.2}, {pose(0.01, 0), 0.2}}, {0, 0}), std::log(2), 1e-12);
}

TEST(Entropy, PosesThatAreNearAHeavierOneAreOne) {
  const SamePose same{0.2, 0.01};
  const WeightedPose heavy{pose(0, 0), 0.6}, turned{pose(0.15, 0), 0.3}, moved{pose(0, 0.02), 0.1};
  EXPECT_EQ(entropy({turned, heavy}, same), 0);
  const double apart = -0.9 * std::log(0.9) - 0.1 * std::log(0.1);
  EXPECT_NEAR(entropy({moved, turned, heavy}, same), apart, 1e-12);
  const WeightedPose farther{pose(0.3, 0), 0.1};
  EXPECT_NEAR(entropy({farther, turned, heavy}, same), apart, 1e-12)
      << "near a pose that is not the heaviest";
}

TEST(Consensus, AFreeAxisSpreadsAMode) {
  Posterior posterior;
  Mode mode;
  mode.weight = 1;
  mode.free_axis = {{0, 0, 0}, {0, 0, 1}, 1.0};
  posterior.modes = {mode};
  const auto poses = poses_of(posterior);
  double weight = 0;
  for (const auto& p : poses) weight += p.weight;
  EXPECT_NEAR(weight, 1, 1e-12);
  EXPECT_LT(consensus(poses, kNone, {}).share, 0.5);
}

}  // namespace
}  // namespace palpate::localization
