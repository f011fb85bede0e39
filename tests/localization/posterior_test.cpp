// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/posterior.hpp"

#include <gtest/gtest.h>

#include "palpate/core/angle.hpp"
#include "palpate/core/random.hpp"

namespace palpate::localization {
namespace {

const std::vector<Eigen::Matrix3d> kNone = {Eigen::Matrix3d::Identity()};

Eigen::Isometry3d pose(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R;
  T.translation() = t;
  return T;
}

TEST(PoseError, MeasuresRotationAndTheCentroidsWay) {
  RandomStream random(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Isometry3d truth = pose(random.rotation(), random.normal3());
    const double angle = random.uniform(0, M_PI);
    const Eigen::Vector3d step = 0.01 * random.normal3();
    const Eigen::Isometry3d other =
        pose(exp_so3(angle * random.unit_vector()) * truth.linear(), truth.translation() + step);
    const PoseError error = pose_error(other, truth, kNone);
    EXPECT_NEAR(error.rotation, angle, 1e-7);
    EXPECT_NEAR(error.translation, step.norm(), 1e-12);
  }
}

TEST(PoseError, IsTheSameForEverySymmetricCopy) {
  RandomStream random(2);
  std::vector<Eigen::Matrix3d> group;
  for (int i = 0; i < 4; ++i) group.push_back(exp_so3({0, 0, i * M_PI / 2}));
  for (int i = 0; i < 20; ++i) {
    const Eigen::Isometry3d truth = pose(random.rotation(), random.normal3());
    const Eigen::Isometry3d estimate =
        pose(exp_so3(0.1 * random.normal3()) * truth.linear(), truth.translation());
    const PoseError error = pose_error(estimate, truth, group);
    for (const Eigen::Matrix3d& R : group) {
      const PoseError copy =
          pose_error(pose(estimate.linear() * R, truth.translation()), truth, group);
      EXPECT_NEAR(copy.rotation, error.rotation, 1e-9);
    }
    EXPECT_LE(error.rotation, pose_error(estimate, truth, kNone).rotation + 1e-12);
  }
}

TEST(PoseTolerance, BothErrorsOfARightPoseAreBelowIt) {
  EXPECT_TRUE(within({4.999 * kDegree, 0.00999}));
  EXPECT_FALSE(within({5.001 * kDegree, 0.00999}));
  EXPECT_FALSE(within({4.999 * kDegree, 0.01001}));
  EXPECT_FALSE(within({kRightPose.rotation, 0}));
  EXPECT_FALSE(within({4.999 * kDegree, 0.00999}, {3 * kDegree, 0.005}));
  EXPECT_TRUE(within({2.999 * kDegree, 0.00499}, {3 * kDegree, 0.005}));
}

TEST(PoseTolerance, IsThatOfARightPoseButForRounding) {
  EXPECT_NEAR(PoseTolerance{}.rotation, kRightPose.rotation, 1e-15);
  EXPECT_EQ(PoseTolerance{}.translation, kRightPose.translation);
}

Mode turning_mode(const Eigen::Isometry3d& at, const FreeAxis& axis) {
  Mode mode;
  mode.T_frame_object = at;
  mode.weight = 1;
  mode.free_axis = axis;
  return mode;
}

TEST(ModeError, IsZeroAlongTheFreeAxisAndGrowsBeyondItsEnds) {
  RandomStream random(3);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Isometry3d middle = pose(random.rotation(), random.normal3());
    const FreeAxis axis{random.normal3(), random.unit_vector(), 0.7};
    const Mode mode = turning_mode(middle, axis);
    const auto turned = [&](double angle) {
      const Eigen::Isometry3d turn = Eigen::Translation3d(axis.point) *
                                     Eigen::AngleAxisd(angle, axis.direction) *
                                     Eigen::Translation3d(-axis.point);
      return turn * middle;
    };
    const PoseError on = mode_error(mode, turned(random.uniform(-0.7, 0.7)), kNone);
    EXPECT_LT(on.rotation, 1e-7);
    EXPECT_LT(on.translation, 1e-7);
    EXPECT_NEAR(mode_error(mode, turned(0.9), kNone).rotation, 0.2, 1e-7);
    EXPECT_NEAR(mode_error(mode, turned(-1.0), kNone).rotation, 0.3, 1e-7);
    EXPECT_NEAR(mode_error(mode, turned(M_PI + 0.1), kNone).rotation, M_PI - 0.8, 1e-7);
  }
}

TEST(PoseProbability, IsTheShareOfAFamilysArc) {
  Mode mode;
  mode.weight = 0.8;
  EXPECT_EQ(pose_probability(mode), 0.8);
  mode.free_axis = FreeAxis{{0, 0, 0}, {0, 0, 1}, 0};
  mode.free_axis->extent = 20 * kDegree;
  EXPECT_NEAR(pose_probability(mode), 0.2, 1e-9);
  mode.free_axis->extent = 2 * kDegree;
  EXPECT_EQ(pose_probability(mode), 0.8);
  mode.free_axis->share = 0.75;
  EXPECT_NEAR(pose_probability(mode), 0.6, 1e-9);
}

TEST(BestProbability, IsThatOfTheFirstModesPose) {
  Posterior posterior;
  EXPECT_EQ(best_probability(posterior), 0);
  posterior.modes.resize(2);
  posterior.modes[0].weight = 0.8;
  posterior.modes[0].free_axis = FreeAxis{{0, 0, 0}, {0, 0, 1}, 20 * kDegree};
  posterior.modes[1].weight = 0.1;
  EXPECT_NEAR(best_probability(posterior), 0.2, 1e-9);
}

TEST(TruthInModes, LooksOnlyAtTheModesThatHoldMostOfTheWeight) {
  Posterior posterior;
  for (const double weight : {0.9, 0.06, 0.04}) {
    Mode mode;
    mode.weight = weight;
    mode.T_frame_object.translation().x() = static_cast<double>(posterior.modes.size());
    posterior.modes.push_back(mode);
  }
  const auto at = [](double x) { return pose(Eigen::Matrix3d::Identity(), {x, 0, 0}); };
  EXPECT_TRUE(covers(posterior, at(0.009), kNone));
  EXPECT_FALSE(covers(posterior, at(0.011), kNone));
  EXPECT_TRUE(covers(posterior, at(1), kNone));
  EXPECT_FALSE(covers(posterior, at(2), kNone));
  EXPECT_FALSE(covers({}, at(0), kNone));
  const Eigen::Isometry3d tilted = pose(exp_so3({0, 6 * kDegree, 0}), {0, 0, 0});
  EXPECT_FALSE(covers(posterior, tilted, kNone));
}

TEST(TruthInCredibleSet, LooksAtFurtherPosesWhereTheModesDoNotSuffice) {
  Posterior posterior;
  posterior.modes.resize(1);
  posterior.modes[0].weight = 0.3;
  posterior.residual_set = {pose(Eigen::Matrix3d::Identity(), {1, 0, 0})};
  const auto at = [](double x) { return pose(Eigen::Matrix3d::Identity(), {x, 0, 0}); };
  EXPECT_TRUE(truth_in_credible_set(posterior, at(0.009), kNone));
  EXPECT_TRUE(truth_in_credible_set(posterior, at(1.009), kNone));
  EXPECT_FALSE(truth_in_credible_set(posterior, at(1.011), kNone));
  EXPECT_FALSE(covers(posterior, at(1.009), kNone));
  posterior.modes[0].weight = 0.96;
  EXPECT_FALSE(truth_in_credible_set(posterior, at(1), kNone));
}

TEST(Posterior, SaysHowMuchItDoesNotList) {
  Posterior posterior;
  EXPECT_EQ(posterior.residual_mass(), 1);
  posterior.modes.resize(2);
  posterior.modes[0].weight = 0.5;
  posterior.modes[1].weight = 0.2;
  EXPECT_NEAR(posterior.residual_mass(), 0.3, 1e-12);
  posterior.modes[1].weight = 0.5 + 1e-9;  // rounding
  EXPECT_EQ(posterior.residual_mass(), 0);
}

TEST(PoseStatus, HasNames) {
  EXPECT_EQ(to_string(PoseStatus::certain), "certain");
  EXPECT_EQ(to_string(PoseStatus::ambiguous), "ambiguous");
  EXPECT_EQ(to_string(PoseStatus::no_pose), "no_pose");
}

}  // namespace
}  // namespace palpate::localization
