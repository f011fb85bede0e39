// SPDX-License-Identifier: Apache-2.0
#include "localization/search/symmetry_group.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/localization/posterior.hpp"

namespace palpate::localization {
namespace {

/// Turns about a line every 2 degrees, with the flips if asked.
std::vector<Eigen::Matrix3d> turns_about(const Eigen::Vector3d& axis, bool flips) {
  std::vector<Eigen::Matrix3d> group;
  const Eigen::Matrix3d flip =
      Eigen::AngleAxisd(M_PI, frame_with_z(axis).col(0)).toRotationMatrix();
  for (int k = 0; k < 180; ++k) {
    group.emplace_back(Eigen::AngleAxisd(2 * M_PI * k / 180, axis));
    if (flips) group.push_back(group.back() * flip);
  }
  return group;
}

double min_distance(const std::vector<Eigen::Matrix3d>& set, const Eigen::Matrix3d& R) {
  double least = M_PI;
  for (const auto& S : set) least = std::min(least, rotation_distance(S, R));
  return least;
}

TEST(SymmetryGroup, FindsTheNearestOfAList) {
  RandomStream random(1);
  const std::vector<Eigen::Matrix3d> listed = {Eigen::Matrix3d::Identity(),
                                               exp_so3({0, 0, M_PI / 2}), exp_so3({0, 0, M_PI}),
                                               exp_so3({0, 0, -M_PI / 2})};
  const SymmetryGroup group(listed);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Matrix3d R = random.rotation();
    const Eigen::Matrix3d nearest(group.nearest(Eigen::Quaterniond(R)));
    EXPECT_NEAR(rotation_distance(nearest, R), min_distance(listed, R), 1e-9);
  }
}

TEST(SymmetryGroup, TurnsContinuouslyAboutALine) {
  RandomStream random(2);
  for (const bool flips : {false, true}) {
    const Eigen::Vector3d axis = random.unit_vector();
    const auto listed = turns_about(axis, flips);
    const SymmetryGroup group(listed);
    for (int i = 0; i < 100; ++i) {
      const Eigen::Matrix3d R = random.rotation();
      const Eigen::Matrix3d nearest(group.nearest(Eigen::Quaterniond(R)));
      const double least = min_distance(listed, R), found = rotation_distance(nearest, R);
      EXPECT_LE(found, least + 1e-9);
      EXPECT_GT(found, least - 0.02);  // of which half a step is 1 deg
      EXPECT_NEAR(std::abs(axis.dot(nearest * axis)), 1, 1e-9);
    }
  }
}

TEST(SymmetryGroup, OfABallHoldsEveryRotation) {
  RandomStream random(3);
  std::vector<Eigen::Matrix3d> covering = {Eigen::Matrix3d::Identity()};
  for (int i = 0; i < 4000; ++i) covering.push_back(random.rotation());
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 20; ++i) {
    Eigen::Isometry3d turned = here;
    turned.linear() = random.rotation();
    turned.translation().x() = 0.004;
    const PoseError error = pose_error(turned, here, covering);
    EXPECT_LT(error.rotation, 1e-6);
    EXPECT_NEAR(error.translation, 0.004, 1e-9);
  }
}

TEST(SymmetryGroup, LeavesOutTurnsThatAreNotSeen) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -1).normalized();
  for (const bool flips : {false, true}) {
    const Eigen::Matrix3d seen = SymmetryGroup(turns_about(axis, flips)).seen_rotations();
    EXPECT_LT((seen * axis).norm(), 1e-6);
    const Eigen::Vector3d across = frame_with_z(axis).col(0);
    EXPECT_LT((seen * across - across).norm(), 1e-6);
  }
  const SymmetryGroup none({Eigen::Quaterniond::Identity()});
  EXPECT_TRUE(none.seen_rotations().isIdentity());
}

}  // namespace
}  // namespace palpate::localization
