// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "palpate/core/error.hpp"
#include "palpate/registration/cloud_registration.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using geometry::PointCloud;
using testing::rotation_error_deg;

PointCloud bunny_points(std::size_t points, std::uint64_t seed) {
  PointCloud cloud;
  for (const auto& s :
       geometry::sample_surface(testing::bunny(), points, RandomStream(seed, "cloud"))) {
    cloud.points.push_back(s.point);
  }
  return cloud;
}

Eigen::Isometry3d pose_of(std::uint64_t seed) {
  RandomStream random(seed, "pose");
  return testing::random_pose(random);
}

PointCloud scaled(PointCloud cloud, double scale) {
  for (auto& p : cloud.points) p *= scale;
  return cloud;
}

CloudOptions coarse() { return {.features = {.max_points = 1500}}; }

TEST(RegisterClouds, EstimatesTheScaleOfAWholeAndOfAPart) {
  const PointCloud target = bunny_points(6000, 1), whole = bunny_points(6000, 2);
  PointCloud part;
  for (const auto& p : whole.points) {
    if (p.x() > -0.015) part.points.push_back(p);
  }
  CloudOptions options = coarse();
  options.registration.estimate_scale = true;
  using Case = std::pair<PointCloud, double>;
  for (const auto& [cloud, scale] : {Case(whole, 0.001), Case(part, 3.7)}) {
    const PointCloud source = scaled(geometry::transformed(pose_of(3).inverse(), cloud), 1 / scale);
    const auto found = register_clouds(source, target, options);
    ASSERT_EQ(found.result.status, RegistrationStatus::kFound) << scale;
    EXPECT_NEAR(found.result.scale / scale, 1, 0.003);
    EXPECT_LT(rotation_error_deg(*found.result.T_target_source, pose_of(3)), 1);
    EXPECT_LT(found.result.false_alarms, 0.01);
  }
}

// Three walls are the same at any scale about their corner.
TEST(RegisterClouds, ACornerOfThreeWallsHasNoScale) {
  RandomStream random(4, "corner");
  PointCloud corners[2];
  for (auto& corner : corners) {
    for (int i = 0; i < 6000; ++i) {
      const double z = random.uniform(0, 0.2), y = random.uniform(0, 0.15);
      Eigen::Vector3d p(random.uniform(0, 0.1), y, z);
      p[i % 3] = 0;
      corner.points.push_back(p);
    }
  }
  CloudOptions options = coarse();
  options.registration.estimate_scale = true;
  for (const double scale : {1.0, 2.0}) {
    const auto found = register_clouds(scaled(corners[0], scale), corners[1], options).result;
    EXPECT_EQ(found.status, RegistrationStatus::kDegenerate);
    EXPECT_FALSE(found.T_target_source);
    ASSERT_EQ(found.free_motions.size(), 1u);
    EXPECT_EQ(found.free_motions[0].kind, FreeMotion::Kind::kScaling);
    EXPECT_LT(found.free_motions[0].point.norm(), 0.002);
  }
}

TEST(RegisterClouds, APlateOfUnknownScaleSlides) {
  RandomStream random(8, "plates");
  PointCloud plates[2];
  for (auto& plate : plates) {
    for (int i = 0; i < 3000; ++i) {
      const double y = random.uniform(-0.07, 0.07);
      plate.points.emplace_back(random.uniform(-0.1, 0.1), y, 0);
    }
  }
  CloudOptions options = coarse();
  options.registration.estimate_scale = true;
  const auto found = register_clouds(scaled(plates[0], 3), plates[1], options).result;
  EXPECT_EQ(found.status, RegistrationStatus::kDegenerate);
  EXPECT_FALSE(found.T_target_source);
  EXPECT_EQ(found.free_motions.size(), 3u);
}

TEST(RegisterClouds, FindsEachInstanceOnce) {
  const Eigen::Isometry3d poses[] = {pose_of(5), Eigen::Translation3d(0.3, 0, 0) * pose_of(6)};
  PointCloud scene;
  for (std::uint64_t k = 0; k < 2; ++k) {
    const PointCloud one = geometry::transformed(poses[k], bunny_points(6000, 10 + k));
    scene.points.insert(scene.points.end(), one.points.begin(), one.points.end());
  }
  CloudOptions options = coarse();
  options.registration.instances = 4;
  const auto found = register_clouds(bunny_points(6000, 9), scene, options).result;
  ASSERT_TRUE(found.T_target_source);
  ASSERT_EQ(found.instances.size(), 1u);
  const Eigen::Isometry3d answers[] = {*found.T_target_source, found.instances[0].T_target_source};
  for (const auto& truth : poses) {
    EXPECT_EQ(std::ranges::count_if(answers,
                                    [&](const auto& T) {
                                      return rotation_error_deg(T, truth) < 2 &&
                                             (T.translation() - truth.translation()).norm() < 0.002;
                                    }),
              1);
  }
}

TEST(RegisterClouds, AScaleExcludesInstancesAndAnInitialPose) {
  const PointCloud cloud = bunny_points(500, 1);
  CloudOptions options = coarse();
  options.registration.estimate_scale = true;
  options.registration.instances = 2;
  EXPECT_THROW(register_clouds(cloud, cloud, options), BadInput);
  options.registration.instances = 1;
  options.registration.initial = Eigen::Isometry3d::Identity();
  EXPECT_THROW(register_clouds(cloud, cloud, options), BadInput);
  options.registration.initial.reset();
  const PointCloud three{{cloud.points[0], cloud.points[1], cloud.points[2]}, {}};
  EXPECT_EQ(register_clouds(three, cloud, options).result.status, RegistrationStatus::kDegenerate);
}

// A grid about a far point would hold all others in one cell; a wire has no normals.
TEST(RegisterClouds, AFarPointAndAWireDoNotSpoilACloud) {
  const PointCloud target = bunny_points(6000, 1);
  PointCloud source = geometry::transformed(pose_of(3).inverse(), bunny_points(6000, 2));
  source.points[17] = {1e10, 0, -1e10};
  for (int i = 0; i < 100; ++i) source.points.emplace_back(0.5 + 0.002 * i, 0, 0);
  for (const bool far_target : {false, true}) {
    PointCloud other = target;
    if (far_target) other.points.emplace_back(0, 1e300, 0);
    const auto found = register_clouds(source, other, coarse()).result;
    ASSERT_TRUE(found.T_target_source);
    EXPECT_LT(rotation_error_deg(*found.T_target_source, pose_of(3)), 2);
  }
}

}  // namespace
}  // namespace palpate::registration
