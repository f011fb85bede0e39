// SPDX-License-Identifier: Apache-2.0
#include "localization/search/modes.hpp"

#include <gtest/gtest.h>

#include "palpate/core/angle.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

constexpr std::size_t kMost = 16;
const PoseFamily::Symmetries kNone = {Eigen::Quaterniond::Identity()};

PosePoint disturbed(const PosePoint& pose, double rotation, double translation,
                    RandomStream& random) {
  return {Eigen::Quaterniond(exp_so3(rotation * random.normal3())) * pose.q,
          pose.t + translation * random.normal3()};
}

std::vector<PosePoint> cloud(const PosePoint& pose, int count, RandomStream& random) {
  std::vector<PosePoint> result;
  for (int i = 0; i < count; ++i) {
    result.push_back(disturbed(pose, 1 * kDegree, 0.001, random));
  }
  return result;
}

void append(std::vector<PosePoint>& to, const std::vector<PosePoint>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

PosePoint turned(const PosePoint& pose, const FreeAxis& axis, double angle) {
  return PoseFamily(pose, axis).at(angle);
}

TEST(FindModes, MeasuresWeightsOnTheOtherPopulation) {
  RandomStream random(1);
  const PosePoint a(Eigen::Quaterniond(random.rotation()), random.normal3());
  const PosePoint b(Eigen::Quaterniond(random.rotation()), random.normal3());
  auto chosen_on = cloud(a, 600, random), weighed_on = cloud(a, 260, random);
  append(chosen_on, cloud(b, 200, random));
  append(weighed_on, cloud(b, 140, random));
  const auto modes = find_modes(chosen_on, weighed_on, kNone, kMost);
  ASSERT_EQ(modes.size(), 2U);
  EXPECT_NEAR(modes[0].weight, 0.65, 1e-9);
  EXPECT_NEAR(modes[1].weight, 0.35, 1e-9);
  EXPECT_LT((modes[0].T_frame_object.translation() - a.t).norm(), 0.0005);
  EXPECT_LT(rotation_distance(modes[0].T_frame_object.linear(), a.q.toRotationMatrix()), 0.01);
}

TEST(FindModes, SharesTheWeightWhereThePopulationsDisagree) {
  RandomStream random(2);
  const PosePoint a(Eigen::Quaterniond(random.rotation()), random.normal3());
  const PosePoint b(Eigen::Quaterniond(random.rotation()), random.normal3());
  auto chosen_on = cloud(a, 600, random), weighed_on = cloud(a, 100, random);
  append(chosen_on, cloud(b, 200, random));
  append(weighed_on, cloud(b, 300, random));
  const auto modes = find_modes(chosen_on, weighed_on, kNone, kMost);
  ASSERT_EQ(modes.size(), 2U);
  EXPECT_NEAR(modes[0].weight, 0.5, 1e-9);
  EXPECT_NEAR(modes[1].weight, 0.5, 1e-9);
}

TEST(FindModes, GivesHalfAPosesWeightToWhatTheOtherPopulationDoesNotHave) {
  RandomStream random(3);
  const PosePoint a(Eigen::Quaterniond(random.rotation()), random.normal3());
  const PosePoint b(Eigen::Quaterniond(random.rotation()), random.normal3());
  const auto modes = find_modes(cloud(a, 100, random), cloud(b, 100, random), kNone, kMost);
  ASSERT_EQ(modes.size(), 1U);
  EXPECT_EQ(modes[0].weight, 0.5 / 100);
}

TEST(FindModes, CountsSymmetricCopiesOnce) {
  RandomStream random(4);
  std::vector<Eigen::Matrix3d> turns;
  for (int i = 0; i < 12; ++i) turns.push_back(exp_so3({0, 0, i * M_PI / 6}));
  const SymmetryGroup group(turns);
  const PosePoint a(Eigen::Quaterniond(random.rotation()), random.normal3());
  std::vector<PosePoint> poses;
  for (const auto& s : group.rotations()) append(poses, cloud({a.q * s, a.t}, 40, random));
  const auto modes = find_modes(poses, poses, group, kMost);
  ASSERT_EQ(modes.size(), 1U);
  EXPECT_NEAR(modes[0].weight, 1, 0.01);
  EXPECT_FALSE(modes[0].free_axis);
}

TEST(FindModes, CovarianceIsThatOfTheMembers) {
  RandomStream random(5);
  const PosePoint a(Eigen::Quaterniond(random.rotation()), random.normal3());
  const auto poses = cloud(a, 4000, random);
  const auto modes = find_modes(poses, poses, kNone, kMost);
  ASSERT_FALSE(modes.empty());
  Matrix6d expected = Matrix6d::Zero();
  expected.diagonal() << Eigen::Vector3d::Constant(kDegree * kDegree),
      Eigen::Vector3d::Constant(1e-6);
  const Vector6d scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6d off = scale.asDiagonal() * (modes[0].covariance - expected) * scale.asDiagonal();
  EXPECT_LT(off.cwiseAbs().maxCoeff(), 0.1);
}

struct Family {
  PosePoint middle;
  FreeAxis axis;
  std::vector<PosePoint> poses;
};
Family noisy_family(double extent, int count, RandomStream& random) {
  Family family{{Eigen::Quaterniond(random.rotation()), 0.1 * random.normal3()},
                {0.1 * random.normal3(), random.unit_vector(), extent},
                {}};
  family.axis.point = family.middle.t + 0.03 * random.unit_vector();
  for (int i = 0; i < count; ++i) {
    const double angle = random.uniform(-extent, extent);
    family.poses.push_back(
        disturbed(turned(family.middle, family.axis, angle), 1 * kDegree, 0.001, random));
  }
  return family;
}

TEST(FindModes, AFamilyIsOneModeWithItsFreeAxis) {
  RandomStream random(6);
  for (const double extent : {30 * kDegree, 100 * kDegree, 160 * kDegree}) {
    const Family family = noisy_family(extent, 1200, random);
    const auto modes = find_modes(family.poses, family.poses, kNone, kMost);
    ASSERT_FALSE(modes.empty());
    ASSERT_TRUE(modes[0].free_axis) << extent;
    const FreeAxis& axis = *modes[0].free_axis;
    EXPECT_GT(modes[0].weight, 0.98);
    EXPECT_GT(std::abs(axis.direction.dot(family.axis.direction)), std::cos(2 * kDegree));
    EXPECT_NEAR(axis.extent, extent, 4 * kDegree);
    EXPECT_NEAR(axis.share.value(), 5 * kDegree / extent, 0.05);
    const Eigen::Vector3d off = axis.point - family.axis.point;
    EXPECT_LT(off.cross(family.axis.direction).norm(), 0.003);
    for (const double angle : {-extent, 0.0, extent}) {
      const auto truth = turned(family.middle, family.axis, angle).isometry();
      const PoseError error = mode_error(modes[0], truth, {Eigen::Matrix3d::Identity()});
      EXPECT_LT(error.rotation, 4 * kDegree);
      EXPECT_LT(error.translation, 0.004);
    }
  }
}

// Where the turns differ in probability, the pose is the likeliest, and stated as likely as it is.
TEST(FindModes, TheBestPoseOfAFamilyIsWhereItIsDensest) {
  RandomStream random(12);
  Family family = noisy_family(60 * kDegree, 400, random);
  const double likeliest = 25 * kDegree;
  std::vector<PosePoint> weighed_on = family.poses;
  for (int i = 0; i < 300; ++i) {
    const auto near = turned(family.middle, family.axis, likeliest + 4 * kDegree * random.normal());
    (i % 2 ? family.poses : weighed_on).push_back(disturbed(near, kDegree, 0.001, random));
  }
  const auto modes = find_modes(family.poses, weighed_on, kNone, kMost);
  ASSERT_TRUE(modes.at(0).free_axis);
  const auto best = turned(family.middle, family.axis, likeliest).isometry();
  const PoseError off = pose_error(modes[0].T_frame_object, best, {Eigen::Matrix3d::Identity()});
  EXPECT_LT(off.rotation, 3 * kDegree);
  const double expected = (400 * 5.0 / 60 + 150 * 0.79) / 550;  // 0.79: within 1.25 sigma
  EXPECT_NEAR(pose_probability(modes[0]), expected, 0.06);
  for (const double angle : {-58 * kDegree, 58 * kDegree}) {
    const auto end = turned(family.middle, family.axis, angle).isometry();
    EXPECT_LT(mode_error(modes[0], end, {Eigen::Matrix3d::Identity()}).rotation, 4 * kDegree);
  }
}

TEST(FindModes, AllRoundHasExtentPi) {
  RandomStream random(7);
  const Family family = noisy_family(M_PI, 1200, random);
  const auto modes = find_modes(family.poses, family.poses, kNone, kMost);
  ASSERT_FALSE(modes.empty());
  ASSERT_TRUE(modes[0].free_axis);
  EXPECT_DOUBLE_EQ(modes[0].free_axis->extent, M_PI);
  const Eigen::Matrix3d rotation = modes[0].covariance.topLeftCorner<3, 3>();  // not along the axis
  EXPECT_NEAR(rotation.trace(), 2 * kDegree * kDegree, kDegree * kDegree);
}

TEST(FindModes, NoMoreThanAskedForHeaviestFirstAndNoMoreThanAllTheWeight) {
  RandomStream random(8);
  std::vector<PosePoint> poses;
  for (int i = 0; i < 1200; ++i) {
    poses.emplace_back(Eigen::Quaterniond(random.rotation()), 0.05 * random.normal3());
  }
  for (int i = 0; i < 30; ++i)
    append(poses, cloud(poses[static_cast<std::size_t>(i)], 20 + i, random));
  const auto modes = find_modes(poses, poses, kNone, kMost);
  EXPECT_EQ(modes.size(), kMost);
  double sum = 0;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    sum += modes[i].weight;
    EXPECT_LE(modes[i].weight, modes[i == 0 ? 0 : i - 1].weight);
  }
  EXPECT_LT(sum, 1);
}

TEST(FindModes, ListsAsManyAsAreAskedFor) {
  std::vector<PosePoint> poses;  // 40 places far apart, each held by ten poses
  for (int i = 0; i < 400; ++i) {
    poses.emplace_back(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.1 * (i % 40), 0, 0));
  }
  EXPECT_EQ(find_modes(poses, poses, kNone, 3).size(), 3u);
  EXPECT_EQ(find_modes(poses, poses, kNone, 64).size(), 40u);
}

TEST(FindModes, ListsScatteredPosesOnlyUntilAllButAFewAreHeld) {
  std::vector<PosePoint> poses;  // 800 of one place, the rest each by itself
  const auto place = [](int i) { return Eigen::Vector3d(0.1 * i, 0, 0); };
  for (int i = 0; i < 800; ++i) poses.emplace_back(Eigen::Quaterniond::Identity(), place(0));
  for (int i = 0; i < 20; ++i) poses.emplace_back(Eigen::Quaterniond::Identity(), place(1 + i));
  EXPECT_EQ(find_modes(poses, poses, kNone, 64).size(), 1u);
  for (int i = 20; i < 60; ++i) poses.emplace_back(Eigen::Quaterniond::Identity(), place(1 + i));
  double sum = 0;
  for (const Mode& mode : find_modes(poses, poses, kNone, 64)) sum += mode.weight;
  EXPECT_GT(sum, 0.95);
}

}  // namespace
}  // namespace palpate::localization
