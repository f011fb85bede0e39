// SPDX-License-Identifier: Apache-2.0
#include "registration/cloud_candidates.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "palpate/geometry/objects/known_object.hpp"
#include "registration/cloud_refinement.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using geometry::PointCloud;
using testing::rotation_error_deg;

PointCloud sampled(const geometry::TriangleMesh& mesh, std::size_t points,
                   const RandomStream& random) {
  constexpr double kNoise = 3e-4;  // m an axis
  PointCloud cloud;
  RandomStream noise = random.fork("noise");
  for (const auto& s : geometry::sample_surface(mesh, points, random.fork("points"))) {
    cloud.points.push_back(s.point + kNoise * noise.normal3());
  }
  return cloud;
}

const geometry::TriangleMesh& mug() {
  static const geometry::TriangleMesh mesh = geometry::load_known_object("mug").mesh;
  return mesh;
}

bool any_near(const std::vector<Eigen::Isometry3d>& poses, const Eigen::Isometry3d& T) {
  return std::ranges::any_of(poses, [&](const auto& pose) {
    return rotation_error_deg(pose, T) < 5 && (pose.translation() - T.translation()).norm() < 0.005;
  });
}

// A mug is its own mirror image in the plane of its handle.
TEST(CloudCandidates, AMirrorImageOfAMugDeterminesItsPose) {
  RandomStream random(1, "mirror image");
  const PointCloud source = sampled(mug(), 4000, random.fork("source"));
  const Eigen::Isometry3d truth = testing::random_pose(random);
  const PointCloud mirrored = mirror_image(source);
  // The mug's frame has the handle in the plane y = 0.
  Eigen::Isometry3d T_mirrored =
      truth * Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ());
  double off = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector3d p = T_mirrored * mirrored.points[i], q = source.points[i];
    off = std::max(off, (p - truth * Eigen::Vector3d(q.x(), -q.y(), q.z())).norm());
  }
  ASSERT_LT(off, 1e-9);
  EXPECT_TRUE(any_near(unmirrored(source, T_mirrored), truth));
}

TEST(CloudCandidates, HalfTurnsComeBackToThePose) {
  RandomStream random(2, "half turns");
  const PointCloud source = sampled(mug(), 4000, random.fork("source"));
  const Eigen::Isometry3d truth = testing::random_pose(random);
  for (const auto& T : turned_about_axes(source, truth, 2)) {
    EXPECT_GT(rotation_error_deg(T, truth), 170);
    EXPECT_TRUE(any_near(turned_about_axes(source, T, 2), truth));
  }
}

TEST(CloudCandidates, AlignedAxesIncludeThePose) {
  const auto bracket = geometry::load_known_object("bracket").mesh;
  RandomStream random(4, "axes");
  const Eigen::Isometry3d truth = testing::random_pose(random);
  const PointCloud source = sampled(bracket, 4000, random.fork("source"));
  const PointCloud target =
      geometry::transformed(truth, sampled(bracket, 1000, random.fork("target")));
  const auto poses = with_axes_aligned(source, target);
  EXPECT_TRUE(any_near(poses, truth));
  for (const auto& T : poses) EXPECT_GT(T.linear().determinant(), 0);
}

TEST(CloudCandidates, TheBetterFitIsTheTruth) {
  RandomStream random(3, "better fit");
  PointCloud source = sampled(mug(), 4000, random.fork("source")),
             target = sampled(mug(), 5000, random.fork("target"));
  const Eigen::Isometry3d truth = testing::random_pose(random);
  target = geometry::transformed(truth, std::move(target));
  add_normals(source, {}, 1);
  add_normals(target, {}, 1);
  const auto others = turned_about_axes(source, truth, 2);
  const auto better = better_fitting(source, target, others[0], {others[2], truth}, 0.004, {});
  ASSERT_TRUE(better);
  EXPECT_LT(rotation_error_deg(better->T_target_source, truth), 1);
  EXPECT_GT(better->deviations, 3);
  EXPECT_FALSE(better_fitting(source, target, truth, others, 0.004, {}));
}

// Features put this mug upside down, with fewer than 1e-12 false alarms: most of it is round.
TEST(RegisterClouds, AMugIsNotTurnedOver) {
  const RandomStream random(10, "conditions");
  RandomStream draw = random.fork("draw");
  const Eigen::Isometry3d truth = testing::random_pose(draw);
  const PointCloud source = sampled(mug(), 6000, random.fork("source")),
                   target =
                       geometry::transformed(truth, sampled(mug(), 8000, random.fork("target")));
  const auto found = register_clouds(source, target).result;
  ASSERT_TRUE(found.T_target_source);
  EXPECT_LT(rotation_error_deg(*found.T_target_source, truth), 2);
  EXPECT_LT(found.false_alarms, 0.01);
}

// Its matches of features exclude chance by far with 2e-41 false alarms, upside down.
TEST(CloudCandidates, ABracketThatIsClearlyUpsideDownIsTurnedOver) {
  const auto mesh = geometry::load_known_object("bracket").mesh;
  const RandomStream random(9603, "conditions");
  RandomStream draw = random.fork("draw");
  const Eigen::Isometry3d truth = testing::random_pose(draw);
  const PointCloud target =
      geometry::transformed(truth, sampled(mesh, 8000, random.fork("target")));
  const auto found = register_clouds(sampled(mesh, 6000, random.fork("source")), target);
  ASSERT_TRUE(found.result.T_target_source);
  EXPECT_LT(rotation_error_deg(*found.result.T_target_source, truth), 1);
}

TEST(CloudCandidates, OnlyPosesThatBringPointsNearerArePromising) {
  RandomStream random(6, "promising");
  const auto mesh = geometry::load_known_object("bracket").mesh;
  const PointCloud source = sampled(mesh, 4000, random.fork("source"));
  const Eigen::Isometry3d truth = testing::random_pose(random);
  const PointCloud target =
      geometry::transformed(truth, sampled(mesh, 4000, random.fork("target")));
  const auto turned = turned_about_axes(source, truth, 2);
  ASSERT_EQ(turned.size(), 6);
  EXPECT_EQ(promising(source, target, truth, turned, 0.004, {})->size(), 0);
  // A little off, three times the bound still reach the target, but one does not.
  Eigen::Isometry3d off = truth;
  off.translation() += 0.006 * Eigen::Vector3d(1, 1, 1).normalized();
  const auto kept = promising(source, target, off, {truth, off}, 0.004, {});
  ASSERT_EQ(kept->size(), 1);
  EXPECT_TRUE(kept->front().isApprox(truth, 0));
  // Where a part of the source is far from the target, nothing is clear.
  EXPECT_FALSE(promising(source, target, turned[0], {truth}, 0.002, {}));
}

/// A box with a small plate off its middle, which alone distinguishes it from its mirror image.
PointCloud box_with_plate(std::size_t points, RandomStream random) {
  PointCloud cloud;
  const Eigen::Vector3d size(0.05, 0.08, 0.12);
  for (std::size_t i = 0; i < points; ++i) {
    const double z = random.uniform(0, 1), y = random.uniform(0, 1), x = random.uniform(0, 1);
    Eigen::Vector3d p(x, y, z);
    const std::size_t face = random.index(7);
    if (face < 6) {
      p[static_cast<Eigen::Index>(face / 2)] = static_cast<double>(face % 2);
      cloud.points.push_back(p.cwiseProduct(size));
    } else {
      cloud.points.emplace_back(0.05 + 0.03 * p[0], 0.01, 0.02 * p[2]);
    }
  }
  return cloud;
}

// Its matches are clear upside down, too.
TEST(CloudCandidates, AClearPoseThatFitsBetterMirroredIsLookedAt) {
  const PointCloud source = box_with_plate(5000, RandomStream(1, "plate"));
  const PointCloud target = box_with_plate(5000, RandomStream(2, "plate"));
  const auto same = register_clouds(source, target);
  ASSERT_TRUE(same.result.T_target_source);
  EXPECT_LT(rotation_error_deg(*same.result.T_target_source, Eigen::Isometry3d::Identity()), 1);
  const auto mirrored = register_clouds(source, mirror_image(target));
  EXPECT_TRUE(mirrored.result.mirrored);
  EXPECT_FALSE(mirrored.result.T_target_source);
}

// The mirror image at half turns from where it fits, at which nearest neighbours stay.
TEST(CloudCandidates, AMirrorImageIsFoundFromAHalfTurn) {
  const Eigen::Isometry3d box_on_box(Eigen::Translation3d(-0.05, 0, 0));
  const CloudOptions options;
  for (const std::uint64_t seed : {1u, 3u}) {
    PointCloud source = box_with_plate(3000, RandomStream(seed, "plate")),
               target = mirror_image(box_with_plate(3000, RandomStream(seed + 1, "plate")));
    for (auto* cloud : {&source, &target}) add_normals(*cloud, options.features, 1);
    const auto starts = turned_about_axes(mirror_image(source), Eigen::Isometry3d::Identity(), 2);
    for (const Eigen::Isometry3d& start : starts) {
      CloudRegistration registration;
      registration.noise_bound = 0.005;
      registration.result.status = RegistrationStatus::kFound;
      registration.result.T_target_source = box_on_box;
      refuse_if_mirrored(source, target, start, {}, options, registration);
      EXPECT_TRUE(registration.result.mirrored) << seed;
      EXPECT_FALSE(registration.result.T_target_source) << seed;
    }
  }
}

TEST(CloudCandidates, ReflectionsOfTheSourceAtAPose) {
  RandomStream random(3, "plate");
  const PointCloud source = box_with_plate(3000, random.fork("source"));
  const Eigen::Isometry3d T = testing::random_pose(random);
  const auto reflections = reflected(source, T);
  ASSERT_EQ(reflections.size(), 6);
  for (const auto& reflection : reflections) {
    EXPECT_NEAR(reflection.linear().determinant(), -1, 1e-9);
    EXPECT_TRUE((T.inverse() * reflection * T.inverse() * reflection)
                    .isApprox(Eigen::Isometry3d::Identity(), 1e-9));
  }
}

// The line through both makes the scene turn freely, as far as its size goes.
TEST(CloudCandidates, OneOfTwoThingsThatLieFarApartIsFound) {
  RandomStream random(4, "far apart");
  const auto mesh = geometry::load_known_object("bracket").mesh;
  const PointCloud source = sampled(mesh, 4000, random.fork("source"));
  const Eigen::Isometry3d first = testing::random_pose(random);
  Eigen::Isometry3d second = testing::random_pose(random);
  second.translation() += Eigen::Vector3d(1.6, 0.8, 0.3);
  PointCloud scene = geometry::transformed(first, sampled(mesh, 4000, random.fork("first")));
  const PointCloud other =
      geometry::transformed(second, sampled(mesh, 4000, random.fork("second")));
  scene.points.insert(scene.points.end(), other.points.begin(), other.points.end());
  const auto found = register_clouds(source, scene);
  EXPECT_NE(found.result.status, RegistrationStatus::kDegenerate);
  ASSERT_TRUE(found.result.T_target_source);
  EXPECT_TRUE(any_near({first, second}, *found.result.T_target_source));
}

}  // namespace
}  // namespace palpate::registration
