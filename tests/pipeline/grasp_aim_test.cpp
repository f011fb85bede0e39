// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/grasp_aim.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "palpate/core/random.hpp"
#include "palpate/geometry/shapes.hpp"

namespace palpate::pipeline {
namespace {

constexpr double kClosingAngle = -0.35;
constexpr double kStep = std::numbers::pi / 36;  // between the directions that are tried

/// Angle between two lines in the plane, rad.
double angle_between_lines(double a, double b) {
  return std::abs(std::remainder(a - b, std::numbers::pi));
}

Eigen::Isometry3d turned_at(double yaw, const Eigen::Vector3d& place) {
  return Eigen::Translation3d(place) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
}

TEST(GraspAim, ClosesOnTheNarrowSideOfABoxAtItsMiddle) {
  const auto box = geometry::box_mesh({0.050, 0.094, 0.040});
  RandomStream random(3);
  for (int i = 0; i < 200; ++i) {
    const double yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
    const Eigen::Vector3d place(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 0.02);
    const auto aim = aim_from_above(box, turned_at(yaw, place), kClosingAngle);
    // The box's x axis, the 50 mm side, points along yaw; thumb and fingers close along it.
    EXPECT_LE(angle_between_lines(aim.yaw + kClosingAngle, yaw), kStep / 2 + 1e-9);
    EXPECT_LT((aim.place - place.head<2>()).norm(), 1e-9);
  }
}

TEST(GraspAim, MiddleOfTheJawsIsThatOfTheShapeNotOfItsOrigin) {
  auto box = geometry::box_mesh({0.050, 0.094, 0.040});
  const Eigen::Vector3d offset(0.012, 0, 0);
  for (auto& vertex : box.vertices) vertex += offset;
  RandomStream random(4);
  for (int i = 0; i < 100; ++i) {
    const double yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
    const auto pose = turned_at(yaw, {0.03, -0.02, 0.02});
    const auto aim = aim_from_above(box, pose, kClosingAngle);
    const Eigen::Vector2d middle = (pose * offset).head<2>();
    const double closing = aim.yaw + kClosingAngle;
    const Eigen::Vector2d across(std::cos(closing), std::sin(closing));
    EXPECT_NEAR(across.dot(aim.place - middle), 0, 1e-9);
  }
}

TEST(GraspAim, ClosingAngleOnlyTurnsTheHand) {
  const auto box = geometry::box_mesh({0.050, 0.094, 0.040});
  const auto pose = turned_at(0.4, {0.01, 0.02, 0.02});
  const auto straight = aim_from_above(box, pose, 0);
  const auto turned = aim_from_above(box, pose, 0.7);
  EXPECT_NEAR(straight.yaw - turned.yaw, 0.7, 1e-12);
  EXPECT_EQ(straight.place, turned.place);
}

}  // namespace
}  // namespace palpate::pipeline
