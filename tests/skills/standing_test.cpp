// SPDX-License-Identifier: Apache-2.0
#include "skills/place/standing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "palpate/skills/place/place_target.hpp"

namespace palpate::skills {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kError = 0.03;  // rad, of a tilt
const geometry::ObjectModel kBox(geometry::load_known_object("box"));
const geometry::ObjectModel kBottle(geometry::load_known_object("bottle"));

/// The stable pose in which the object is lowest.
std::size_t lying(const geometry::ObjectModel& object) {
  const auto& poses = object.object().stable_poses;
  const auto lowest = std::ranges::min_element(poses, {}, &geometry::StablePose::height);
  return static_cast<std::size_t>(lowest - poses.begin());
}

/// In a stable pose, turned about the vertical, then rolled in the direction in which it leans
/// most easily, by an angle (rad).
Eigen::Isometry3d rolled(const geometry::ObjectModel& object, std::size_t stable_pose,
                         double angle) {
  Eigen::Isometry3d T(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()));
  const auto& pose = object.object().stable_poses[stable_pose];
  T.linear() *= pose.R_table_object;
  const Eigen::Vector3d towards =
      T.linear() * object.resting_slack()[stable_pose].directions().front();
  T.linear() = Eigen::AngleAxisd(angle, towards.cross(Eigen::Vector3d::UnitZ())) * T.linear();
  T.translation() << 0.1, 0.2, pose.height;
  return T;
}

double lowest_of(const geometry::TriangleMesh& mesh, const Eigen::Isometry3d& T) {
  double low = 1;
  for (const auto& vertex : mesh.vertices) low = std::min(low, (T * vertex).z());
  return low;
}

TEST(Standing, ABoxThatSeemsTiltedStandsFlat) {
  for (const double angle : {0.0, 3.0, -4.0}) {
    const Standing standing =
        standing_of(kBox, rolled(kBox, lying(kBox), angle * kDegree), kError, {}, 5 * kDegree);
    EXPECT_LT(standing.lean, 1 * kDegree) << angle;
    EXPECT_GT(standing.upright, 0.95) << angle;
    EXPECT_LT(Eigen::AngleAxisd(standing.T_flat_object.linear()).angle(), 1 * kDegree);
  }
}

// Its centre of mass may be off by some millimetres, as the estimate has it.
TEST(Standing, ALyingBottleThatHasRolledStaysSo) {
  const Eigen::Isometry3d T = rolled(kBottle, lying(kBottle), 10 * kDegree);
  const Standing standing = standing_of(kBottle, T, kError, {}, 5 * kDegree);
  EXPECT_GT(standing.lean, 6 * kDegree);
  EXPECT_LT(standing.lean, 10 * kDegree);
  EXPECT_LT(standing.upright, 0.3);
  const Eigen::Isometry3d stands = laid_flat(kBottle.object(), T) * standing.T_flat_object;
  EXPECT_LT(Eigen::AngleAxisd(stands.linear().transpose() * T.linear()).angle(),
            10.01 * kDegree - standing.lean);
  EXPECT_NEAR(lowest_of(kBottle.object().mesh, stands), 0, 1e-9);
}

// A centre of mass that is off may hold it on a side on which its mesh would not stay.
TEST(Standing, AFarLeanIsBelievedOfABoxToo) {
  const Standing standing =
      standing_of(kBox, rolled(kBox, lying(kBox), 15 * kDegree), kError, {}, 5 * kDegree);
  EXPECT_GT(standing.lean, 12 * kDegree);
  EXPECT_LT(standing.upright, 0.05);
  // Swung between two fingertips, it says little of how it stood.
  const Standing swung =
      standing_of(kBox, rolled(kBox, lying(kBox), 15 * kDegree), 0.3, {}, 5 * kDegree);
  EXPECT_GT(swung.upright, 0.85);
}

TEST(Standing, WhatWasNotSeenToStandMayRollAsFarAsItsShapeLetsIt) {
  const double box = upright_probability(kBox, lying(kBox), {}, 5 * kDegree);
  const double bottle = upright_probability(kBottle, lying(kBottle), {}, 5 * kDegree);
  EXPECT_GT(box, 0.88);
  EXPECT_LT(bottle, box - 0.05);
  estimation::EstimationOptions exact;
  exact.surface_sigma = exact.centroid_sigma = 1e-5;
  EXPECT_NEAR(upright_probability(kBottle, lying(kBottle), exact, 5 * kDegree), box, 0.02);
}

}  // namespace
}  // namespace palpate::skills
