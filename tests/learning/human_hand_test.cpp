// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/demonstrations/human_hand.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::learning {
namespace {

HumanJoints random_joints(RandomStream& random) {
  HumanJoints q;
  for (int i = 0; i < kHumanJoints; ++i) {
    const hand::Range& range = human_ranges()[static_cast<std::size_t>(i)];
    q[i] = random.uniform(range.low, range.high);
  }
  return q;
}

Eigen::Isometry3d random_pose(RandomStream& random) {
  Eigen::Isometry3d T(random.rotation());
  T.translation() = random.normal3();
  return T;
}

TEST(HumanHand, RangesAreThoseOfTableA2) {
  EXPECT_EQ(human_ranges()[static_cast<std::size_t>(human_joint_index("FF2"))].high, 1.745);
  EXPECT_EQ(human_ranges()[static_cast<std::size_t>(human_joint_index("LF3"))].low, -0.785);
  EXPECT_EQ(human_ranges()[static_cast<std::size_t>(human_joint_index("WR2"))].high, 0.349);
  EXPECT_EQ(human_ranges()[static_cast<std::size_t>(human_joint_index("TH1"))].low, -0.262);
  EXPECT_THROW(human_joint_index("FF5"), BadInput);
}

TEST(HumanHand, BonesKeepTheirLengths) {
  RandomStream random(1);
  const HumanShape shape{1.1, {0.9, 1, 1.05, 1.1, 1.2}};
  const HandKeypoints rest =
      human_keypoints(HumanJoints::Zero(), shape, Eigen::Isometry3d::Identity());
  for (int trial = 0; trial < 50; ++trial) {
    const HandKeypoints moved = human_keypoints(random_joints(random), shape, random_pose(random));
    for (const HumanBone& bone : human_bones()) {
      if (bone.from == 0 && bone.to >= keypoint(hand::FingerName::ring, 0))
        continue;  // the palm hollows
      EXPECT_NEAR((moved.col(bone.to) - moved.col(bone.from)).norm(),
                  (rest.col(bone.to) - rest.col(bone.from)).norm(), 1e-12);
    }
  }
}

TEST(HumanHand, PoseAndSizeActAsOneExpects) {
  RandomStream random(2);
  const HumanJoints q = random_joints(random);
  const Eigen::Isometry3d T = random_pose(random);
  const HandKeypoints there = human_keypoints(q, {}, T);
  const HandKeypoints here = human_keypoints(q, {}, Eigen::Isometry3d::Identity());
  const HandKeypoints expected = (T.linear() * here).colwise() + T.translation();
  EXPECT_LT((there - expected).norm(), 1e-12);
  const HumanShape twice{2, {2, 2, 2, 2, 2}};
  EXPECT_LT((human_keypoints(q, twice, Eigen::Isometry3d::Identity()) - 2 * here).norm(), 0.08);
}

TEST(HumanHand, FlexionBendsEveryFingerTowardsThePalm) {
  const HandKeypoints rest =
      human_keypoints(HumanJoints::Zero(), {}, Eigen::Isometry3d::Identity());
  for (const char* joint : {"FF3", "MF2", "RF1", "LF3", "LF5", "RF5"}) {
    HumanJoints q = HumanJoints::Zero();
    q[human_joint_index(joint)] = 0.3;
    const HandKeypoints bent = human_keypoints(q, {}, Eigen::Isometry3d::Identity());
    EXPECT_LT((bent - rest).row(1).minCoeff(), -0.002) << joint;
    EXPECT_LT((bent - rest).row(1).maxCoeff(), 1e-12) << joint;
  }
}

TEST(HumanHand, TheThumbOpposesTheLittleFinger) {
  HumanJoints q = HumanJoints::Zero();
  q[human_joint_index("TH5")] = q[human_joint_index("TH4")] = 0.7;
  const int tip = keypoint(hand::FingerName::thumb, 3);
  const auto before = human_keypoints(HumanJoints::Zero(), {}, Eigen::Isometry3d::Identity());
  const auto after = human_keypoints(q, {}, Eigen::Isometry3d::Identity());
  EXPECT_LT(after(0, tip), before(0, tip) - 0.02);
  EXPECT_LT(after(1, tip), -0.01);  // before the palm
}

TEST(HumanHand, FindsThePalmsFrame) {
  RandomStream random(3);
  const Eigen::Isometry3d T = random_pose(random);
  const auto keypoints = human_keypoints(HumanJoints::Zero(), {}, T);
  EXPECT_LT((palm_frame(keypoints) - T.linear()).norm(), 0.1);
  EXPECT_THROW(palm_frame(HandKeypoints::Zero()), BadInput);
}

}  // namespace
}  // namespace palpate::learning
