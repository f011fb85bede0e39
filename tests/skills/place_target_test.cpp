// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/place_target.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "geometry/collider_meshes.hpp"
#include "geometry/objects/stable_poses.hpp"
#include "geometry/objects/symmetry.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/geometry/mesh/mass_properties.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "palpate/localization/posterior.hpp"

namespace palpate::skills {
namespace {

constexpr double kReach = 0.5;

const geometry::KnownObject& known(const std::string& name) {
  static std::map<std::string, geometry::KnownObject> objects;
  if (!objects.contains(name)) objects[name] = geometry::load_known_object(name);
  return objects[name];
}

PlaceTarget parsed(std::string_view text, const FixtureOptions& fixture = {}) {
  return parse_target(text, known("box"), fixture, kReach, 3);
}

std::string text_of(const Eigen::Isometry3d& T) {
  std::string text;
  for (const double x : pose_to_row_major(T)) text += fmt::format("{} ", x);
  return text;
}

/// What is said of a target that cannot be.
std::string complaint(std::string_view text, const FixtureOptions& fixture = {}) {
  try {
    parsed(text, fixture);
  } catch (const BadInput& error) {
    return error.what();
  }
  return "none";
}

Eigen::Isometry3d on_table(const Eigen::Vector2d& xy) {
  return resting_pose(known("box"), 0, xy, 0.3);
}

TEST(PlaceTarget, AnotherStablePoseIsNeverTheOneItStartsIn) {
  for (const char* name : {"box", "mug", "bottle", "bunny", "bracket"}) {
    const auto& object = known(name);
    std::set<std::size_t> drawn;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const std::size_t start = seed % object.stable_poses.size();
      const PlaceTarget target = stable_pose_target(object, start, -1, kReach, seed);
      EXPECT_EQ(target.kind, PlaceTarget::Kind::pose);
      const Eigen::Matrix3d& from = object.stable_poses[start].R_table_object;
      EXPECT_FALSE(same_side_up(object, target.T_world_object.linear(), from, 0.05)) << name;
      const NearestStablePose rest = nearest_stable_pose(object, target.T_world_object.linear());
      EXPECT_LT(rest.tilt, 1e-6);
      drawn.insert(rest.stable_pose);
      const double radius = target.T_world_object.translation().head<2>().norm();
      EXPECT_GE(radius, 0.1 - 1e-9);
      EXPECT_LE(radius, 0.25 + 1e-9);
      EXPECT_TRUE(stable_pose_target(object, start, -1, kReach, seed)
                      .T_world_object.isApprox(target.T_world_object));
    }
    EXPECT_GT(drawn.size(), 1u) << name;
  }
  const PlaceTarget wanted = stable_pose_target(known("mug"), 0, 1, kReach, 5);
  EXPECT_EQ(nearest_stable_pose(known("mug"), wanted.T_world_object.linear()).stable_pose, 1u);
  EXPECT_THROW((void)stable_pose_target(known("mug"), 0, 999, kReach, 5), BadInput);
  EXPECT_THROW((void)stable_pose_target(known("mug"), 0, -2, kReach, 5), BadInput);
  EXPECT_THROW((void)stable_pose_target(known("mug"), 999, -1, kReach, 5), BadInput);
}

TEST(PlaceTarget, WhatIsDrawnIsWithinReach) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto spot = parse_target("random", known("box"), {}, 0.15, seed);
    EXPECT_LE(spot.xy.norm(), 0.15);
    const auto pose = stable_pose_target(known("box"), 0, -1, 0.15, seed);
    EXPECT_LE(pose.T_world_object.translation().head<2>().norm(), 0.15);
  }
  EXPECT_THROW((void)parse_target("random", known("box"), {}, 0.05, 1), BadInput);
  EXPECT_THROW((void)stable_pose_target(known("box"), 0, -1, 0.05, 1), BadInput);
}

TEST(PlaceTarget, AStanceIsOfTheTargetStablePoseAlone) {
  PlaceOptions options;
  options.stable_pose = 1;
  for (const char* target : {"", "random", "fixture", "0.1,0,0"}) {
    options.target = target;
    try {
      (void)evaluation::place_target(known("box"), options, 3, 0);
      FAIL() << target;
    } catch (const BadInput& error) {
      EXPECT_NE(std::string(error.what()).find("place.stable_pose = 1"), std::string::npos);
    }
  }
  options.target = "stable_pose";
  EXPECT_TRUE(evaluation::place_target(known("box"), options, 3, 4));
}

TEST(PlaceTarget, WhereAllSidesAreAlikeThereIsNoOtherStablePose) {
  geometry::KnownObject die = known("box");
  die.stable_poses.resize(1);
  EXPECT_THROW((void)stable_pose_target(die, 0, -1, kReach, 5), BadInput);
}

TEST(PlaceTarget, IsASpotAPoseOrTheFixture) {
  const PlaceTarget spot = parsed("0.1, -0.2,1.5");
  EXPECT_EQ(spot.kind, PlaceTarget::Kind::spot);
  EXPECT_EQ(spot.xy, Eigen::Vector2d(0.1, -0.2));
  EXPECT_EQ(spot.yaw, 1.5);

  const PlaceTarget pose = parsed(text_of(on_table({0.1, 0.2})));
  EXPECT_EQ(pose.kind, PlaceTarget::Kind::pose);
  EXPECT_LT((pose.T_world_object.matrix() - on_table({0.1, 0.2}).matrix()).norm(), 1e-5);

  FixtureOptions fixture;
  fixture.stable_pose = 1;
  const PlaceTarget slot = parsed("fixture", fixture);
  EXPECT_EQ(slot.kind, PlaceTarget::Kind::fixture);
  EXPECT_NEAR(slot.T_world_object.translation().z(), known("box").stable_poses[1].height, 1e-12);
}

TEST(PlaceTarget, RandomSpotsAreInReachAndFollowTheSeed) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto a = parse_target("random", known("box"), {}, kReach, seed);
    const auto b = parse_target("random", known("box"), {}, kReach, seed);
    const auto c = parse_target("random", known("box"), {}, kReach, seed + 1);
    EXPECT_EQ(a.xy, b.xy);
    EXPECT_NE(a.xy, c.xy);
    EXPECT_LE(a.xy.norm(), 0.25 + 1e-12);
    EXPECT_GE(a.xy.norm(), 0.10 - 1e-12);
  }
}

TEST(PlaceTarget, WhatCannotBeIsNamed) {
  EXPECT_NE(complaint("somewhere").find("is not a target"), std::string::npos);
  EXPECT_NE(complaint("1,2").find("is not a target"), std::string::npos);
  EXPECT_NE(complaint("0.6,0,0").find("out of reach"), std::string::npos);
  EXPECT_NE(complaint("nan,0,0").find("is not a target"), std::string::npos);
  EXPECT_NE(complaint(text_of(on_table({0.4, 0.4}))).find("out of reach"), std::string::npos);

  Eigen::Isometry3d T = on_table({0.1, 0.1});
  T.translation().z() -= 0.02;
  EXPECT_NE(complaint(text_of(T)).find("inside the table"), std::string::npos);
  T.translation().z() += 0.05;
  EXPECT_NE(complaint(text_of(T)).find("in the air"), std::string::npos);

  FixtureOptions tight;
  tight.tolerance = -0.001;
  EXPECT_NE(complaint("fixture", tight).find("too small"), std::string::npos);
  FixtureOptions unknown;
  unknown.stable_pose = 99;
  EXPECT_NE(complaint("fixture", unknown).find("stable poses 0.."), std::string::npos);
}

TEST(PlaceTarget, APoseThatDoesNotRestIsNamed) {
  const auto& box = known("box");
  Eigen::Isometry3d T = on_table({0.1, 0.1});
  T.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()) * T.linear();
  double low = 1;
  for (const auto& v : box.mesh.vertices) low = std::min(low, (T * v).z());
  T.translation().z() -= low;
  EXPECT_NE(complaint(text_of(T)).find("does not rest"), std::string::npos);
}

// A body of revolution lies on any of its facets, of which only some are listed.
TEST(PlaceTarget, ARoundObjectMayLieOnAnyOfItsSides) {
  geometry::KnownObject can;
  std::vector<Eigen::Vector2d> outline;
  for (int k = 0; k < 64; ++k) {
    const double angle = 2 * std::numbers::pi * k / 64;
    outline.emplace_back(0.03 * std::cos(angle), 0.03 * std::sin(angle));
  }
  can.mesh = geometry::prism(outline, 0.16);
  const Eigen::Vector3d centroid = geometry::mass_properties(can.mesh, 1).centroid;
  for (auto& v : can.mesh.vertices) v -= centroid;
  can.stable_poses = geometry::stable_poses(can.mesh, Eigen::Vector3d::Zero());
  can.symmetries = geometry::rotational_symmetries(can.mesh, Eigen::Vector3d::Zero());
  ASSERT_GT(can.symmetries.size(), 24u);
  const auto lying = std::ranges::max_element(can.stable_poses, {}, [](const auto& stable_pose) {
    return std::abs(stable_pose.R_table_object(0, 2));
  });
  const auto i = static_cast<std::size_t>(lying - can.stable_poses.begin());
  const Eigen::Isometry3d T = resting_pose(can, i, {0.1, 0.1}, 0);
  for (const auto& S : can.symmetries) {
    Eigen::Isometry3d same = T;
    same.linear() = T.linear() * S;
    EXPECT_NO_THROW(parse_target(text_of(same), can, {}, kReach, 3)) << S;
  }
}

/// A block whose top slopes by 6 deg: its half turn keeps the shape within tolerance, but maps no
/// side that it lies on exactly to another.
geometry::KnownObject wedge() {
  geometry::KnownObject object;
  object.mesh = geometry::box_mesh({0.06, 0.05, 0.12});
  for (auto& v : object.mesh.vertices) {
    if (v.y() > 0) v.y() += std::tan(6 * std::numbers::pi / 180) * v.x();
  }
  const Eigen::Vector3d centroid = geometry::mass_properties(object.mesh, 1).centroid;
  for (auto& v : object.mesh.vertices) v -= centroid;
  object.stable_poses = geometry::stable_poses(object.mesh, Eigen::Vector3d::Zero());
  object.symmetries = geometry::rotational_symmetries(object.mesh, Eigen::Vector3d::Zero());
  return object;
}

/// The stable poses that an estimate may report of an object in one, right but for a symmetry.
std::set<std::size_t> taken_for(const geometry::KnownObject& object, std::size_t stable_pose) {
  std::set<std::size_t> images;
  for (const auto& S : object.symmetries) {
    images.insert(nearest_stable_pose(object, object.stable_poses[stable_pose].R_table_object * S)
                      .stable_pose);
  }
  return images;
}

TEST(PlaceTarget, OfASpotIsTheSameWhicheverOfTheEqualPosesIsFound) {
  PlaceTarget spot;
  spot.xy = {0.1, -0.05};
  spot.yaw = 0.7;
  std::vector<geometry::KnownObject> objects = {wedge()};
  for (const auto& name : geometry::built_in_objects()) objects.push_back(known(name));
  for (const auto& object : objects) {
    for (std::size_t stable_pose = 0; stable_pose < object.stable_poses.size(); ++stable_pose) {
      const Eigen::Isometry3d T = target_pose(spot, object, stable_pose);
      EXPECT_EQ(T.translation().head<2>(), spot.xy);
      EXPECT_NEAR(T.translation().z(), object.stable_poses[stable_pose].height, 1e-12);
      EXPECT_TRUE(
          T.linear().row(2).isApprox(object.stable_poses[stable_pose].R_table_object.row(2), 1e-9));
      for (const std::size_t image : taken_for(object, stable_pose)) {
        // As far apart as the symmetry maps the stable poses, and not by half a turn.
        EXPECT_LT(localization::pose_error(target_pose(spot, object, image), T, object.symmetries)
                      .rotation,
                  5 * std::numbers::pi / 180)
            << object.name << " " << stable_pose << " taken for " << image;
      }
    }
  }
}

TEST(PlaceTarget, ABlockWithASlopingTopIsMappedBesideItsOtherStablePoses) {
  const auto block = wedge();
  ASSERT_EQ(block.symmetries.size(), 2u);
  double farthest = 0;
  for (const auto& stable_pose : block.stable_poses) {
    for (const auto& S : block.symmetries) {
      farthest =
          std::max(farthest, nearest_stable_pose(block, stable_pose.R_table_object * S).tilt);
    }
  }
  EXPECT_GT(farthest, 3 * std::numbers::pi / 180);
  EXPECT_LT(farthest, 5 * std::numbers::pi / 180);
}

/// Least distance of what is lower than the walls from any of them, negative inside; vertices
/// alone.
double room(const geometry::KnownObject& object, const Eigen::Isometry3d& T,
            const planning::Fixture& fixture) {
  double least = 1;
  for (const auto& v : object.mesh.vertices) {
    const Eigen::Vector3d p = T * v;
    if (p.z() > 2 * fixture.front().half_extents.z()) continue;
    for (const auto& box : fixture) {
      const Eigen::Vector3d out = (box.T_world_box.inverse() * p).cwiseAbs() - box.half_extents;
      least = std::min(least, out.maxCoeff() > 0 ? out.cwiseMax(0).norm() : out.maxCoeff());
    }
  }
  return least;
}

TEST(Fixture, LeavesItsToleranceAndNoMore) {
  for (const char* name : {"mug", "box", "bracket"}) {
    const auto& object = known(name);
    for (const int stable_pose : {0, 1}) {
      FixtureOptions options;
      options.stable_pose = stable_pose;
      options.yaw = 0.4;
      options.height = 0.03;  // high, so that walls meet vertices of a coarse mesh
      const auto fixture = make_fixture(object, options);
      const Eigen::Isometry3d seated = resting_pose(object, static_cast<std::size_t>(stable_pose),
                                                    {options.x, options.y}, options.yaw);
      EXPECT_GT(room(object, seated, fixture), options.tolerance - 1e-9) << name << stable_pose;
      for (int k = 0; k < 8; ++k) {  // it cannot be shifted out of the slot
        const double angle = 2 * std::numbers::pi * k / 8;
        Eigen::Isometry3d shifted = seated;
        shifted.translation() +=
            2.2 * options.tolerance * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
        EXPECT_LT(room(object, shifted, fixture), options.tolerance) << name << stable_pose;
      }
    }
  }
}

TEST(LaidFlat, KeepsPlaceAndRests) {
  RandomStream random(5, "tilts");
  for (const auto& name : geometry::built_in_objects()) {
    const auto& object = known(name);
    for (int k = 0; k < 20; ++k) {
      const std::size_t stable_pose = static_cast<std::size_t>(k) % object.stable_poses.size();
      const Eigen::Isometry3d rest = resting_pose(object, stable_pose, {0.1, -0.05}, 0.3 * k);
      Eigen::Isometry3d tilted = rest;
      const Eigen::Vector3d axis(random.normal(), random.normal(), 0);
      tilted.linear() = exp_so3(0.02 * axis.normalized()) * rest.linear();
      tilted.translation().z() += 0.01 * random.normal();
      const Eigen::Isometry3d flat = laid_flat(object, tilted);
      EXPECT_LT(nearest_stable_pose(object, flat.linear()).tilt, 1e-6);
      EXPECT_LT((flat.translation() - rest.translation()).norm(), 0.02);
      EXPECT_EQ(flat.translation().head<2>(), tilted.translation().head<2>());
      EXPECT_LT(rotation_distance(flat.linear(), tilted.linear()), 0.06);
    }
  }
}

}  // namespace
}  // namespace palpate::skills
