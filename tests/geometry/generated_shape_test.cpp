// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/generated_shape.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/repair/mesh_repair.hpp"

namespace palpate::geometry {
namespace {

TEST(GeneratedShape, IsAClosedSolidOfHouseholdSize) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const TriangleMesh mesh = generated_shape(seed);
    const MeshReport report = inspect(mesh);
    EXPECT_TRUE(report.watertight) << seed;
    EXPECT_EQ(report.components, 1) << seed;
    EXPECT_GT(report.volume, 5e-6) << seed;
    EXPECT_GE(report.triangles, 1000) << seed;
    EXPECT_LE(report.triangles, 50000) << seed;
    const double longest = bounds(mesh).sizes().maxCoeff();
    EXPECT_GE(longest, 0.035) << seed;
    EXPECT_LE(longest, 0.22) << seed;
  }
}

TEST(GeneratedShape, IsTheSameForASeedAndDiffersBetweenSeeds) {
  const TriangleMesh mesh = generated_shape(7), again = generated_shape(7),
                     other = generated_shape(8);
  EXPECT_EQ(mesh.vertices, again.vertices);
  EXPECT_EQ(mesh.triangles, again.triangles);
  EXPECT_NE(mesh.vertices, other.vertices);
}

TEST(GeneratedShape, IsAnObjectByItsName) {
  const KnownObject object = load_known_object("generated:3");
  EXPECT_EQ(object.name, "generated:3");
  EXPECT_GE(object.mass, 0.05);
  EXPECT_FALSE(object.stable_poses.empty());
  EXPECT_EQ(generated_seed("generated:3"), 3u);
  EXPECT_FALSE(generated_seed("mug"));
}

TEST(GeneratedShape, RangesOfNamesAreWrittenOut) {
  const std::vector<std::string> expected = {"mug", "generated:8", "generated:9", "generated:10",
                                             "generated:5"};
  EXPECT_EQ(expand_object_names({"mug", "generated:8-10", "generated:5"}), expected);
}

TEST(GeneratedShape, RefusesWhatIsNoSeedOrRange) {
  EXPECT_THROW(load_known_object("generated:"), BadInput);
  EXPECT_THROW(load_known_object("generated:x"), BadInput);
  EXPECT_THROW(load_known_object("generated:-1"), BadInput);
  EXPECT_THROW(expand_object_names({"generated:9-8"}), BadInput);
  EXPECT_THROW(expand_object_names({"generated:0-100000"}), BadInput);
}

}  // namespace
}  // namespace palpate::geometry
