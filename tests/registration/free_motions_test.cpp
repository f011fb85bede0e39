// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/free_motions.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/registration/cloud_registration.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using Kind = FreeMotion::Kind;
using Surface = std::function<Eigen::Vector3d(RandomStream&)>;

constexpr double kTurn = 2 * std::numbers::pi;

Eigen::Vector3d around(double radius, double angle, double z) {
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

geometry::PointCloud cloud_of(const Surface& surface, double noise, std::uint64_t seed) {
  RandomStream random(seed, "surface");
  const Eigen::Isometry3d T = testing::random_pose(random);
  geometry::PointCloud cloud;
  for (int i = 0; i < 4000; ++i) {
    cloud.points.push_back(T * surface(random) + noise * random.normal3());
  }
  return cloud;
}

int count(const std::vector<FreeMotion>& motions, Kind kind) {
  return static_cast<int>(
      std::ranges::count_if(motions, [&](const auto& m) { return m.kind == kind; }));
}

struct Shape {
  std::string name;
  Surface surface;
  int rotations, translations;
};

const std::vector<Shape>& shapes() {
  static const std::vector<Shape> kShapes = {
      {"sphere", [](RandomStream& r) { return Eigen::Vector3d(0.05 * r.unit_vector()); }, 3, 0},
      {"cylinder",
       [](RandomStream& r) { return around(0.03, kTurn * r.uniform(), r.uniform(-0.05, 0.05)); }, 1,
       1},
      {"cone",
       [](RandomStream& r) {
         const double h = std::sqrt(r.uniform(0.1, 1.0));
         return around(0.04 * h, kTurn * r.uniform(), 0.08 * h);
       },
       1, 0},
      {"torus",
       [](RandomStream& r) {
         const double a = kTurn * r.uniform();
         return around(0.05 + 0.015 * std::cos(a), kTurn * r.uniform(), 0.015 * std::sin(a));
       },
       1, 0},
      {"plate",
       [](RandomStream& r) {
         return Eigen::Vector3d(r.uniform(-0.05, 0.05), r.uniform(-0.04, 0.04), 0);
       },
       1, 2},
  };
  return kShapes;
}

TEST(FreeMotions, OfSurfacesThatSlideAlongThemselves) {
  for (const auto& shape : shapes()) {
    for (const double noise : {0.0, 0.0003}) {
      const auto result =
          register_clouds(cloud_of(shape.surface, noise, 1), cloud_of(shape.surface, noise, 2))
              .result;
      EXPECT_EQ(result.status, RegistrationStatus::kDegenerate) << shape.name << noise;
      EXPECT_FALSE(result.T_target_source);
      EXPECT_EQ(count(result.free_motions, Kind::kRotation), shape.rotations)
          << shape.name << noise;
      EXPECT_EQ(count(result.free_motions, Kind::kTranslation), shape.translations) << shape.name;
    }
  }
}

TEST(FreeMotions, OfNoObjectThatHasAPose) {
  for (const std::string name : {"mug", "bottle", "box", "bracket"}) {
    const auto object = geometry::load_known_object(name);
    for (const double noise : {0.0, 0.0003}) {
      geometry::PointCloud clouds[2];
      for (std::uint64_t k = 0; k < 2; ++k) {
        RandomStream random(k, "object");
        for (const auto& s : geometry::sample_surface(object.mesh, 6000, random.fork("points"))) {
          clouds[k].points.push_back(s.point + noise * random.normal3());
        }
      }
      EXPECT_TRUE(register_clouds(clouds[0], clouds[1]).result.free_motions.empty()) << name;
    }
  }
}

// A cone whose radius varies by 6 %: slopes of some degrees, less than the normals' noise squared
// and summed leaves to distinguish them from a round one.
TEST(FreeMotions, OfANearlyRoundSurfaceAreNone) {
  const Surface surface = [](RandomStream& r) {
    const double h = std::sqrt(r.uniform(0.1, 1.0)), a = kTurn * r.uniform();
    const double uneven = 0.03 * (std::cos(2 * a) + std::cos(3 * a + 1));
    return around(0.04 * h * (1 + uneven), a, 0.08 * h);
  };
  int poses_found = 0;
  for (std::uint64_t seed = 1; seed < 9; seed += 2) {
    RandomStream poses[] = {RandomStream(seed, "surface"), RandomStream(seed + 1, "surface")};
    const Eigen::Isometry3d T_source = testing::random_pose(poses[0]),
                            T_target = testing::random_pose(poses[1]);
    const auto found =
        register_clouds(cloud_of(surface, 0.0003, seed), cloud_of(surface, 0.0003, seed + 1));
    EXPECT_TRUE(found.result.free_motions.empty()) << seed;
    if (!found.result.T_target_source) continue;  // so smooth a surface has few features
    ++poses_found;
    EXPECT_LT(
        testing::rotation_error_deg(*found.result.T_target_source, T_target * T_source.inverse()),
        2)
        << seed;
  }
  EXPECT_GT(poses_found, 0);
}

TEST(FreeMotions, AreNamedWhereTheyAre) {
  // A cylinder along x through (0, 0, 1).
  CentredInformation about{.center = {0.2, 0, 1}};
  for (int i = 0; i < 360; ++i) {
    const double a = kTurn * i / 360;
    for (const double x : {-0.5, 0.5}) {
      const Eigen::Vector3d n(0, std::cos(a), std::sin(a)), arm = x * Eigen::Vector3d::UnitX() + n;
      Vector6d row;
      row << arm.cross(n), n;
      about.information += row * row.transpose();
      about.squared_arm += arm.squaredNorm() / 720;
      about.weight_sum += 1;
    }
  }
  const auto motions = free_motions(about, 1e-6);
  ASSERT_EQ(motions.size(), 2u);
  EXPECT_EQ(motions[0].kind, Kind::kTranslation);
  EXPECT_EQ(motions[1].kind, Kind::kRotation);
  for (const auto& motion : motions) EXPECT_NEAR(std::abs(motion.direction.x()), 1, 1e-9);
  EXPECT_NEAR(motions[1].point.z(), 1, 1e-9);
  EXPECT_EQ(to_string(motions[1].kind), "rotation");
}

}  // namespace
}  // namespace palpate::registration
