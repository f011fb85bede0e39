// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/cloud_registration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/geometry/objects/generated_shape.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using geometry::PointCloud;
using testing::rotation_error_deg;
using testing::translation_error_mm;

PointCloud bunny_cloud(std::size_t points, std::uint64_t seed) {
  PointCloud cloud;
  for (const auto& s :
       geometry::sample_surface(testing::bunny(), points, RandomStream(seed, "cloud"))) {
    cloud.points.push_back(s.point);
    cloud.normals.push_back(s.normal);
  }
  return cloud;
}

Eigen::Isometry3d pose_of(std::uint64_t seed) {
  RandomStream random(seed, "pose");
  return testing::random_pose(random);
}

const CloudOptions kCoarse{.features = {.max_points = 1500}};

TEST(RegisterClouds, FindsThePoseOfAScan) {
  const PointCloud target = bunny_cloud(8000, 1);
  for (const bool normals : {true, false}) {
    PointCloud scan = geometry::transformed(pose_of(2).inverse(), bunny_cloud(8000, 2));
    if (!normals) scan.normals.clear();
    const auto found = register_clouds(scan, target, kCoarse);
    ASSERT_EQ(found.result.status, RegistrationStatus::kFound);
    EXPECT_LT(rotation_error_deg(*found.result.T_target_source, pose_of(2)), 2);
    EXPECT_LT(translation_error_mm(*found.result.T_target_source * pose_of(2).inverse(),
                                   Eigen::Isometry3d::Identity()),
              2);
    EXPECT_GT(found.feature_matches, 50u);
    EXPECT_EQ(found.result.weights.size(), found.correspondences.size());
    EXPECT_EQ(found.result.residuals.size(), found.correspondences.size());
  }
}

TEST(RegisterClouds, FindsThePoseOfAPart) {
  PointCloud part;
  const PointCloud whole = bunny_cloud(8000, 3);
  for (const auto& p : whole.points) {
    if (p.x() > -0.01) part.points.push_back(pose_of(4).inverse() * p);
  }
  CloudOptions options = kCoarse;
  options.registration.primitive = Primitive::kPlane;
  const auto found = register_clouds(part, bunny_cloud(8000, 1), options);
  ASSERT_EQ(found.result.status, RegistrationStatus::kFound);
  EXPECT_LT(rotation_error_deg(*found.result.T_target_source, pose_of(4)), 2);
}

// One of the clouds' normals come out inward: some of what then matches agrees with a wrong pose.
TEST(RegisterClouds, NormalsOfOppositeSignsGiveNoWrongPose) {
  for (const std::uint64_t seed : {14u, 49u}) {
    PointCloud source = geometry::transformed(pose_of(seed).inverse(), bunny_cloud(4000, 2 * seed)),
               target = bunny_cloud(4000, 2 * seed + 1);
    source.normals.clear();
    target.normals.clear();
    const auto found = register_clouds(source, target, kCoarse);
    ASSERT_TRUE(found.result.T_target_source);
    EXPECT_LT(rotation_error_deg(*found.result.T_target_source, pose_of(seed)), 2);
    EXPECT_GT(found.feature_matches, 100u);
  }
}

TEST(RegisterClouds, EmptyTinyAndDegenerateClouds) {
  const PointCloud cloud = bunny_cloud(500, 1), empty, one{{{1, 2, 3}}, {}},
                   same{std::vector<Eigen::Vector3d>(50, {1, 2, 3}), {}};
  for (const PointCloud* bad : {&empty, &one, &same}) {
    for (const auto& result :
         {register_clouds(*bad, cloud).result, register_clouds(cloud, *bad).result,
          register_clouds(*bad, *bad).result}) {
      EXPECT_EQ(result.status, RegistrationStatus::kDegenerate);
      EXPECT_FALSE(result.T_target_source);
    }
  }
  PointCloud bad = cloud;
  bad.points[7].x() = std::nan("");
  EXPECT_THROW(register_clouds(bad, cloud), BadInput);
  EXPECT_THROW(register_clouds(cloud, cloud, {.noise_bound = -1.0}), BadInput);
  for (const double voxel : {-1.0, std::nan(""), HUGE_VAL}) {
    CloudOptions options;
    options.features.voxel = voxel;
    EXPECT_THROW(register_clouds(cloud, cloud, options), BadInput) << voxel;
  }
}

// A small cell is enough for so few too many, or for copies, and too small for features.
TEST(RegisterClouds, FewPointsMoreThanTheGridKeepsOrCopies) {
  for (const bool copied : {false, true}) {
    PointCloud clouds[] = {bunny_cloud(1510, 2), bunny_cloud(1510, 1)};
    for (auto& cloud : clouds) {
      cloud.normals.clear();
      if (copied) cloud.points.insert(cloud.points.end(), 1500, cloud.points[0]);
      for (std::size_t i = 0; copied && i < 1500; ++i) cloud.points[1510 + i] = cloud.points[i];
    }
    const double few = suggested_voxel(bunny_cloud(1500, 2), bunny_cloud(1500, 1), 1500);
    EXPECT_NEAR(suggested_voxel(clouds[0], clouds[1], 1500) / few, 1, 0.2);
    const auto found =
        register_clouds(geometry::transformed(pose_of(2).inverse(), clouds[0]), clouds[1], kCoarse);
    ASSERT_TRUE(found.result.T_target_source) << copied;
    EXPECT_LT(rotation_error_deg(*found.result.T_target_source, pose_of(2)), 3);
  }
}

TEST(RegisterClouds, CopiesOfAllPointsAreNoScale) {
  for (const int times : {2, 3, 100}) {
    for (const double jitter : {0.0, 1e-9}) {
      PointCloud clouds[] = {bunny_cloud(1200, 2), bunny_cloud(1200, 1)};
      const double single = suggested_voxel(clouds[0], clouds[1], 1000000);
      RandomStream random(3, "jitter");
      for (auto& cloud : clouds) {
        cloud.normals.clear();
        const auto once = cloud.points;
        for (int k = 1; k < times; ++k) {
          for (const auto& p : once) cloud.points.push_back(p + jitter * random.normal3());
        }
      }
      EXPECT_NEAR(suggested_voxel(clouds[0], clouds[1], 1000000) / single, 1.3, 0.4) << times;
    }
  }
}

TEST(RegisterClouds, RefusesAMirroredCloud) {
  PointCloud mirrored = bunny_cloud(4000, 2);
  for (auto* list : {&mirrored.points, &mirrored.normals}) {
    for (auto& p : *list) p.x() = -p.x();
  }
  const auto found = register_clouds(mirrored, bunny_cloud(4000, 1), kCoarse);
  EXPECT_FALSE(found.result.T_target_source);
  EXPECT_TRUE(found.result.mirrored);
}

TEST(RegisterClouds, ReadsBuffersWhereTheyAre) {
  const PointCloud target = bunny_cloud(12000, 1),
                   source = geometry::transformed(pose_of(2).inverse(), bunny_cloud(12000, 2));
  constexpr std::ptrdiff_t kColumns = 5;
  Eigen::Matrix<double, kColumns, Eigen::Dynamic> rows(kColumns, source.size());
  for (std::size_t i = 0; i < source.size(); ++i) {
    rows.col(static_cast<Eigen::Index>(i)) << 7, source.points[i], 8;
  }
  const geometry::PointView view(rows.data() + 1, source.size(), kColumns * sizeof(double));
  const auto found = register_clouds(view, target, kCoarse),
             same = register_clouds(PointCloud{source.points, {}}, target, kCoarse);
  ASSERT_TRUE(found.result.T_target_source);
  EXPECT_EQ(found.result.T_target_source->matrix(), same.result.T_target_source->matrix());
}

// Coordinates of the surface itself locate a point better than any feature.
TEST(RegisterClouds, TakesFeaturesOfOnesOwn) {
  constexpr double kVoxel = 0.004;
  FeatureCloud described[2];
  for (std::uint64_t k = 0; k < 2; ++k) {
    described[k].cloud = geometry::voxel_sampled(bunny_cloud(8000, k), kVoxel);
    const auto& points = described[k].cloud.points;
    described[k].features.resize(3, static_cast<Eigen::Index>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i) {
      described[k].features.col(static_cast<Eigen::Index>(i)) = points[i].cast<float>();
    }
  }
  described[0].cloud = geometry::transformed(pose_of(3).inverse(), described[0].cloud);
  const auto found = register_described(described[0], described[1], kVoxel);
  ASSERT_EQ(found.result.status, RegistrationStatus::kFound);
  EXPECT_LT(rotation_error_deg(*found.result.T_target_source, pose_of(3)), 1);
  for (const double voxel : {0.0, std::nan(""), HUGE_VAL}) {
    EXPECT_THROW(register_described(described[0], described[1], voxel), BadInput) << voxel;
  }
  described[0].features.conservativeResize(3, 10);
  EXPECT_THROW(register_described(described[0], described[1], kVoxel), BadInput);
}

TEST(RegisterClouds, TurnsAboutGravityAloneOrNotAtAll) {
  const Eigen::Vector3d gravity(0, 0.6, -0.8);
  Eigen::Isometry3d turned(Eigen::Translation3d(0.02, -0.3, 0.1)), shifted = turned;
  turned.rotate(Eigen::AngleAxisd(2.5, gravity));
  const PointCloud target = bunny_cloud(8000, 1), scan = bunny_cloud(8000, 2);
  for (const auto primitive : {Primitive::kPlane, Primitive::kPoint}) {
    CloudOptions options = kCoarse;
    options.registration.primitive = primitive;
    options.registration.rotation_axis = 3 * gravity;
    const auto found =
        register_clouds(geometry::transformed(turned.inverse(), scan), target, options);
    ASSERT_TRUE(found.result.T_target_source);
    EXPECT_LT(rotation_error_deg(*found.result.T_target_source, turned), 0.5);
    EXPECT_NEAR((found.result.T_target_source->linear() * gravity - gravity).norm(), 0, 1e-12);
    options.registration.rotation_axis = std::nullopt;
    options.registration.translation_only = true;
    const auto moved =
        register_clouds(geometry::transformed(shifted.inverse(), scan), target, options);
    ASSERT_TRUE(moved.result.T_target_source);
    EXPECT_EQ(moved.result.T_target_source->linear(), Eigen::Matrix3d::Identity());
    EXPECT_LT((moved.result.T_target_source->translation() - shifted.translation()).norm(), 5e-4);
  }
}

// Turns that gravity excludes are not free; those about it are.
TEST(RegisterClouds, ASphereIsDegenerateByItsAllowedTurns) {
  RandomStream random(1, "sphere");
  PointCloud spheres[2];
  for (auto& sphere : spheres) {
    for (int i = 0; i < 4000; ++i) sphere.points.push_back(0.05 * random.unit_vector());
  }
  CloudOptions options = kCoarse;
  options.registration.rotation_axis = Eigen::Vector3d(1, 1, 0);
  const auto found = register_clouds(spheres[0], spheres[1], options).result;
  EXPECT_EQ(found.status, RegistrationStatus::kDegenerate);
  ASSERT_EQ(found.free_motions.size(), 1u);
  EXPECT_EQ(found.free_motions[0].kind, FreeMotion::Kind::kRotation);
  EXPECT_GT(std::abs(found.free_motions[0].direction.dot(Eigen::Vector3d(1, 1, 0).normalized())),
            0.99);
  options.registration.rotation_axis = std::nullopt;
  options.registration.translation_only = true;
  options.registration.initial = Eigen::Isometry3d(Eigen::Translation3d(0.004, -0.003, 0.002));
  const auto shifted = register_clouds(spheres[0], spheres[1], options).result;
  ASSERT_TRUE(shifted.T_target_source);
  EXPECT_LT(shifted.T_target_source->translation().norm(), 2e-4);
}

TEST(RegisterClouds, RefusesAPoseThatDoesNotFit) {
  // Two sheets of bumps that differ, held together by an initial pose.
  PointCloud sheets[2];
  for (std::uint64_t k = 0; k < 2; ++k) {
    RandomStream random(k, "sheet");
    Eigen::Vector2d waves[6];
    for (auto& w : waves) w = 300 * Eigen::Vector2d(random.normal(), random.normal());
    for (int i = 0; i < 4000; ++i) {
      const Eigen::Vector2d p(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05));
      double height = 0;
      for (const auto& w : waves) height += 0.002 * std::sin(w.dot(p));
      sheets[k].points.emplace_back(p.x(), p.y(), height);
    }
  }
  CloudOptions options;
  options.registration.initial = Eigen::Isometry3d::Identity();
  const auto found = register_clouds(sheets[0], sheets[1], options);
  EXPECT_EQ(found.result.status, RegistrationStatus::kNoConsensus);
  EXPECT_FALSE(found.result.T_target_source);
  EXPECT_TRUE(register_clouds(sheets[0], sheets[0], options).result.T_target_source);
}

TEST(RegisterClouds, ThreadsDoNotMatter) {
  const PointCloud target = bunny_cloud(8000, 1),
                   source = geometry::transformed(pose_of(2).inverse(), bunny_cloud(8000, 2));
  CloudOptions two = kCoarse;
  two.threads = 2;
  const auto one = register_clouds(source, target, kCoarse),
             other = register_clouds(source, target, two);
  ASSERT_TRUE(one.result.T_target_source);
  EXPECT_EQ(one.result.T_target_source->matrix(), other.result.T_target_source->matrix());
  EXPECT_EQ(one.feature_matches, other.feature_matches);
  two.threads = 5;
  const auto many = register_clouds(source, target, two);
  EXPECT_EQ(one.result.T_target_source->matrix(), many.result.T_target_source->matrix());
}

TEST(RegisterClouds, AnotherShapeGivesNoPose) {
  PointCloud ball;
  RandomStream random(5, "ball");
  for (int i = 0; i < 3000; ++i) {
    ball.normals.push_back(random.unit_vector());
    ball.points.push_back(0.05 * ball.normals.back());
  }
  const auto found = register_clouds(bunny_cloud(4000, 1), ball, kCoarse);
  // A ball fits at any angle, so that what little agrees may leave motions free.
  EXPECT_TRUE(found.result.status == RegistrationStatus::kNoConsensus ||
              found.result.status == RegistrationStatus::kDegenerate);
}

PointCloud shape_cloud(std::uint64_t shape, const RandomStream& random) {
  PointCloud cloud;
  RandomStream noise = random.fork("noise");
  for (const auto& s :
       geometry::sample_surface(geometry::generated_shape(shape), 6000, random.fork("points"))) {
    cloud.points.push_back(s.point + 3e-4 * noise.normal3());
  }
  return cloud;
}

// Patches of both lie on one another, where matches agree with their neighbours and normals because
// positions do: with normals counted as evidence of their own each of these has a pose.
TEST(RegisterClouds, MatchesOfDifferentShapesAreNoConsensus) {
  for (const std::uint64_t seed : {670u, 708u, 888u}) {
    const RandomStream random(seed, "different objects");
    RandomStream pose = random.fork("pose");
    const PointCloud target = shape_cloud(seed, random.fork("target")),
                     source = geometry::transformed(testing::random_pose(pose).inverse(),
                                                    shape_cloud(seed + 1, random.fork("source")));
    const double voxel = suggested_voxel(source, target, 3000);
    const FeatureCloud from = describe(source, voxel), to = describe(target, voxel);
    Correspondences pairs;
    for (const auto& match : geometry::mutual_matches(from.features, to.features)) {
      const auto i = static_cast<std::size_t>(match.source),
                 j = static_cast<std::size_t>(match.target);
      pairs.source.push_back(from.cloud.points[i]);
      pairs.target.push_back(to.cloud.points[j]);
      pairs.source_normals.push_back(from.cloud.normals[i]);
      pairs.target_normals.push_back(to.cloud.normals[j]);
    }
    const auto result =
        register_correspondences(pairs, {.noise_bound = 1.5 * voxel, .normal_noise_deg = 10});
    EXPECT_EQ(result.status, RegistrationStatus::kNoConsensus) << seed;
  }
}

// Patches of these agree more than by chance, and lie on one another; the surfaces part beyond.
TEST(RegisterClouds, DifferentShapesContradictOneAnother) {
  for (const std::uint64_t seed : {108u, 172u}) {
    const RandomStream random(seed, "different objects");
    RandomStream pose = random.fork("pose");
    const PointCloud target = shape_cloud(seed, random.fork("target")),
                     source = geometry::transformed(testing::random_pose(pose).inverse(),
                                                    shape_cloud(seed + 1, random.fork("source")));
    const auto refused = register_clouds(source, target);
    EXPECT_EQ(refused.result.status, RegistrationStatus::kNoConsensus) << seed;
    EXPECT_GT(refused.contradiction, 0.1) << seed;
    CloudOptions options;
    options.registration.best_effort = true;
    EXPECT_TRUE(register_clouds(source, target, options).result.T_target_source) << seed;
  }
}

TEST(RegisterClouds, PartsOfOneShapeDoNotContradictOneAnother) {
  const RandomStream random(12, "parts");
  PointCloud parts[2];
  for (std::size_t k = 0; k < 2; ++k) {
    for (const auto& p : shape_cloud(12, random.fork("cloud", k)).points) {
      if (k == 0 ? p.x() > -0.01 : p.z() > -0.01) parts[k].points.push_back(p);
    }
  }
  const auto found = register_clouds(parts[0], parts[1]);
  ASSERT_TRUE(found.result.T_target_source);
  EXPECT_LT(found.overlap, 0.9);
  EXPECT_LT(found.contradiction, 0.05);
}

// The mirror images of these match little better than themselves, but fit far better.
TEST(RegisterClouds, FlagsAMirroredShapeByItsFit) {
  for (const std::uint64_t seed : {6u, 23u}) {
    const RandomStream random(seed, "same object");
    PointCloud source = shape_cloud(seed, random.fork("source"));
    const PointCloud target = shape_cloud(seed, random.fork("target"));
    EXPECT_FALSE(register_clouds(source, target).result.mirrored);
    for (auto& p : source.points) p.x() = -p.x();
    EXPECT_TRUE(register_clouds(source, target).result.mirrored) << seed;
  }
}

TEST(RegisterClouds, ScaleDoesNotMatter) {
  for (const double scale : {1e-6, 1e6}) {
    PointCloud source = geometry::transformed(pose_of(2).inverse(), bunny_cloud(4000, 2)),
               target = bunny_cloud(4000, 1);
    for (auto* cloud : {&source, &target}) {
      for (auto& p : cloud->points) p *= scale;
    }
    const auto found = register_clouds(source, target, kCoarse);
    ASSERT_TRUE(found.result.T_target_source) << scale;
    EXPECT_LT(rotation_error_deg(*found.result.T_target_source, pose_of(2)), 3);
  }
}

TEST(RegisterClouds, AnInitialPoseNeedsRefinements) {
  CloudOptions options;
  options.features.refinements = 0;
  const PointCloud cloud = bunny_cloud(500, 1);
  EXPECT_NO_THROW(register_clouds(cloud, cloud, options));
  options.registration.initial = Eigen::Isometry3d::Identity();
  EXPECT_THROW(register_clouds(cloud, cloud, options), BadInput);
  options.registration.initial.reset();
  options.registration.estimate_scale = true;
  EXPECT_THROW(register_clouds(cloud, cloud, options), BadInput);
}

}  // namespace
}  // namespace palpate::registration
