// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/resting_slack.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/objects/stable_poses.hpp"
#include "palpate/geometry/objects/shapes.hpp"

namespace palpate::geometry {
namespace {

/// A bar of the given size (m) about the origin that lies on its lower face.
KnownObject bar(const Eigen::Vector3d& size) { return make_known_object("bar", box_mesh(size), 1); }

TEST(RestingSlack, ABoxLeansByTheErrorOverItsHalfWidth) {
  const KnownObject object = bar({0.2, 0.04, 0.1});
  for (const StablePose& pose : object.stable_poses) {
    if (std::abs(pose.R_table_object(2, 2)) < 0.99) continue;  // it lies on 200 mm x 40 mm
    const RestingSlack slack(object.mesh, pose);
    EXPECT_NEAR(std::abs(slack.directions()[0].y()), 1, 1e-6) << "it leans over the narrow side";
    EXPECT_NEAR(slack.lean(0, 0.0005), 0.0005 / 0.02, 0.004);
    EXPECT_NEAR(slack.lean(1, 0.0005), 0.0005 / 0.1, 0.001);
    EXPECT_EQ(slack.lean(0, 0), 0);
  }
}

/// A closed cylinder about z, m.
TriangleMesh can_mesh(double radius, double height) {
  constexpr int kAround = 96;
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, -height / 2}, {0, 0, height / 2}};
  for (int i = 0; i < kAround; ++i) {
    const double angle = 2 * std::numbers::pi * i / kAround;
    for (const double z : {-height / 2, height / 2}) {
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  }
  for (int i = 0; i < kAround; ++i) {
    const int low = 2 + 2 * i, next = 2 + 2 * ((i + 1) % kAround);
    mesh.triangles.push_back({0, next, low});
    mesh.triangles.push_back({1, low + 1, next + 1});
    mesh.triangles.push_back({low, next, next + 1});
    mesh.triangles.push_back({low, next + 1, low + 1});
  }
  return mesh;
}

TEST(RestingSlack, ACylinderOnItsSideRollsFreely) {
  const KnownObject object = make_known_object("can", can_mesh(0.03, 0.1), 1);
  for (const StablePose& pose : object.stable_poses) {
    if (std::abs(pose.R_table_object(2, 2)) > 0.01) continue;  // it stands
    const RestingSlack slack(object.mesh, pose);
    EXPECT_GT(slack.lean(0, 0.0005), 0.3);
    EXPECT_LT(slack.lean(1, 0.0005), 0.02);
    EXPECT_NEAR(std::abs(slack.directions()[1].z()), 1, 0.02) << "across its axis";
  }
}

}  // namespace
}  // namespace palpate::geometry
