// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/resting_slack.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/objects/stable_poses.hpp"
#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/geometry/objects/shapes.hpp"

namespace palpate::geometry {
namespace {

/// A bar of the given size (m) about the origin that lies on its lower face.
KnownObject bar(const Eigen::Vector3d& size) { return make_known_object("bar", box_mesh(size), 1); }

TEST(RestingSlack, ABoxLeansByTheErrorOverItsWidth) {
  const KnownObject object = bar({0.2, 0.04, 0.1});
  for (const StablePose& pose : object.stable_poses) {
    if (std::abs(pose.R_table_object(2, 2)) < 0.99) continue;  // it lies on 200 mm x 40 mm
    const RestingSlack slack(object.mesh.vertices, pose);
    EXPECT_NEAR(std::abs(slack.directions()[0].y()), 1, 1e-6) << "it leans over the narrow side";
    EXPECT_NEAR(slack.lean(0, 0.0005), std::sqrt(2) * 0.0005 / 0.04, 0.001);
    EXPECT_NEAR(slack.lean(1, 0.0005), std::sqrt(2) * 0.0005 / 0.2, 0.0005);
    EXPECT_EQ(slack.lean(0, 0), 0);
    EXPECT_EQ(slack.lean(0, 0, 0.005), 0) << "its weight stays over its face";
  }
}

/// Points all over an ellipsoid that lies on its shortest half axis, z.
std::vector<Eigen::Vector3d> ellipsoid(const Eigen::Vector3d& half_axes) {
  constexpr int kPoints = 100000;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kPoints; ++i) {
    const double z = 1 - (2 * i + 1) / double{kPoints};
    const double around = i * std::numbers::pi * (3 - std::sqrt(5));
    const double r = std::sqrt(1 - z * z);
    points.emplace_back(
        half_axes.cwiseProduct(Eigen::Vector3d(r * std::cos(around), r * std::sin(around), z)));
  }
  return points;
}

TEST(RestingSlack, ARoundBodyLeansByTheSlopeOfTheError) {
  constexpr double kLow = 0.03, kWide = 0.04, kLong = 0.1;
  constexpr double kError = 4e-5;  // small, so that it does not roll beyond the error's length
  const StablePose upright{Eigen::Matrix3d::Identity(), kLow, 1};
  const RestingSlack slack(ellipsoid({kLong, kWide, kLow}), upright);
  EXPECT_NEAR(std::abs(slack.directions()[0].y()), 1, 1e-3);
  const auto expected = [&](double half_axis) {
    const double radius = half_axis * half_axis / kLow;
    return kError / kSurfaceErrorLength * radius / (radius - kLow);
  };
  EXPECT_NEAR(slack.lean(0, kError) / expected(kWide), 1, 0.15);
  EXPECT_NEAR(slack.lean(1, kError) / expected(kLong), 1, 0.15);
}

TEST(RestingSlack, ARoundBodyRollsOntoItsCentreOfMass) {
  constexpr double kLow = 0.03, kWide = 0.04, kSigma = 0.001;
  const StablePose upright{Eigen::Matrix3d::Identity(), kLow, 1};
  const RestingSlack slack(ellipsoid({0.1, kWide, kLow}), upright);
  EXPECT_NEAR(slack.lean(0, 0, kSigma) / (kSigma / (kWide * kWide / kLow - kLow)), 1, 0.25);
  EXPECT_NEAR(slack.lean(0, 0.0001, kSigma),
              std::hypot(slack.lean(0, 0.0001), slack.lean(0, 0, kSigma)), 1e-12);
}

/// Corners of a cylinder about z, m, turned about x by an angle, rad.
std::vector<Eigen::Vector3d> can(double radius, double height, int sides, double turn) {
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / sides;
    for (const double z : {-height / 2, height / 2}) {
      corners.push_back(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitX()) *
                        Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), z));
    }
  }
  return corners;
}

TEST(RestingSlack, ACylinderOnItsSideRollsFreelyHoweverItLies) {
  for (const int sides : {48, 96, 200}) {
    for (const double turn : {0.0, 0.1, 0.2, 0.7}) {
      StablePose lying;
      lying.R_table_object =
          Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitY()).toRotationMatrix() *
          Eigen::AngleAxisd(-turn, Eigen::Vector3d::UnitX());
      const RestingSlack slack(can(0.03, 0.1, sides, turn), lying);
      const Eigen::Vector3d axis =
          Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitX()) * Eigen::Vector3d::UnitZ();
      EXPECT_NEAR(std::abs(slack.directions()[1].dot(axis)), 1, 1e-6) << "across its axis";
      EXPECT_GT(slack.lean(0, 0.0003), 0.3) << sides << " sides, turned by " << turn;
      EXPECT_LT(slack.lean(1, 0.0003), 0.01);
      EXPECT_GT(slack.lean(0, 0, 0.003), 0.3);
      EXPECT_EQ(slack.lean(1, 0, 0.003), 0);
    }
  }
}

TEST(RestingSlack, AHandleOnTheTableStopsAMugToOneSide) {
  const ObjectModel mug(load_known_object("mug"));
  int on_handle = 0;
  for (const RestingSlack& slack : mug.resting_slack()) {
    const double against = slack.lean_to(0, 0, 0, 0.003), along = slack.lean_to(1, 0, 0, 0.003);
    EXPECT_NEAR(slack.lean(0, 0, 0.003), std::hypot(against, along) / std::numbers::sqrt2, 1e-12);
    if (std::max(against, along) < 0.1) continue;
    ++on_handle;
    EXPECT_GT(std::max(against, along), 0.3);
    EXPECT_LT(std::min(against, along), 0.02);
  }
  EXPECT_EQ(on_handle, 2) << "it lies on either side of its handle";
}

}  // namespace
}  // namespace palpate::geometry
