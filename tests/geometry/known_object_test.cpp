// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/known_object.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>

#include "data.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "palpate/geometry/repair/mesh_repair.hpp"

namespace palpate::geometry {
namespace {

namespace fs = std::filesystem;

std::string complaint(const std::string& name_or_file) {
  try {
    load_known_object(name_or_file);
  } catch (const BadInput& error) {
    return error.what();
  }
  return "accepted";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class KnownObjectFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("palpate_known_object_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string file_of(const TriangleMesh& mesh, const std::string& name = "thing.ply") {
    save_ply(folder_ / name, mesh);
    return (folder_ / name).string();
  }

  fs::path folder_;
};

TEST(KnownObject, BuiltInsAreWatertightCentredAndComplete) {
  const std::map<std::string, double> masses = {
      {"mug", 0.12}, {"bottle", 0.40}, {"box", 0.40}, {"bracket", 0.25}, {"duck", 0.20}};
  const std::map<std::string, std::size_t> orders = {
      {"mug", 1}, {"bottle", 2}, {"box", 4}, {"bracket", 1}, {"duck", 1}};
  ASSERT_EQ(built_in_objects().size(), masses.size());
  for (const std::string& name : built_in_objects()) {
    const KnownObject object = load_known_object(name);
    EXPECT_EQ(object.name, name);
    EXPECT_TRUE(inspect(object.mesh).watertight) << name;
    EXPECT_EQ(inspect(object.mesh).components, 1) << name;
    EXPECT_EQ(object.mass, masses.at(name));
    EXPECT_LT(object.mass_properties.centroid.norm(), 1e-12);
    EXPECT_EQ(object.symmetries.size(), orders.at(name)) << name;
    ASSERT_FALSE(object.stable_poses.empty());
    double total = 0;
    for (const StablePose& stable_pose : object.stable_poses) total += stable_pose.probability;
    EXPECT_NEAR(total, 1, 1e-12);
  }
}

TEST(KnownObject, UnknownNamesAreAnsweredWithTheBuiltIns) {
  EXPECT_TRUE(contains(complaint("mugg"), "did you mean 'mug'"));
  EXPECT_TRUE(contains(complaint("botle"), "did you mean 'bottle'"));
  EXPECT_TRUE(contains(complaint("Generated:5"), "did you mean 'generated:5'"));
  EXPECT_TRUE(contains(complaint("generate:17"), "did you mean 'generated:17'"));
  EXPECT_FALSE(contains(complaint("Generated:x"), "did you mean"));
  const std::string far = complaint("no/such/file.ply");
  EXPECT_TRUE(contains(far, "no/such/file.ply"));
  EXPECT_TRUE(contains(far, "mug, bottle, box, bracket, duck"));
  EXPECT_FALSE(contains(far, "did you mean"));
  EXPECT_TRUE(contains(complaint(std::string(300, 'n')), "nnn' is neither"));
}

TEST_F(KnownObjectFile, TheBunnyIsNoBuiltInAndSaysHowItIsInstalled) {
  const char* const before = std::getenv("PALPATE_ASSETS");
  const std::string kept = before ? before : "";
  ::setenv("PALPATE_ASSETS", folder_.c_str(), 1);
  const std::string message = complaint("bunny");
  EXPECT_TRUE(contains(message, "./dev bunny installs it")) << message;
  EXPECT_TRUE(contains(message, "duck")) << message;
  EXPECT_EQ(complaint("duck"), "accepted");  // it needs no file
  before ? ::setenv("PALPATE_ASSETS", kept.c_str(), 1) : ::unsetenv("PALPATE_ASSETS");
}

TEST_F(KnownObjectFile, ComesBackInItsOwnFrame) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(0.3, -0.2, 0.1);
  const TriangleMesh moved = transformed(T, bracket_mesh());
  const KnownObject object = load_known_object(file_of(moved));
  EXPECT_EQ(object.name, "thing");
  EXPECT_EQ(object.T_mesh_object.linear(), Eigen::Matrix3d::Identity());
  const auto in_file = bounds(transformed(object.T_mesh_object, object.mesh));
  EXPECT_LT((in_file.min() - bounds(moved).min()).norm(), 1e-9);
  EXPECT_LT((in_file.max() - bounds(moved).max()).norm(), 1e-9);
}

TEST_F(KnownObjectFile, WeighsThreeHundredKilogramsACubicMetreWithinLimits) {
  EXPECT_NEAR(load_known_object(file_of(box_mesh({0.1, 0.1, 0.1}))).mass, 0.3, 1e-9);
  EXPECT_EQ(load_known_object(file_of(box_mesh({0.02, 0.02, 0.02}))).mass, 0.05);
  EXPECT_EQ(load_known_object(file_of(box_mesh({0.2, 0.2, 0.2}))).mass, 0.6);
}

TEST_F(KnownObjectFile, SizesThatAHandCannotHoldAreRefused) {
  const std::string small = complaint(file_of(box_mesh({0.009, 0.005, 0.005})));
  EXPECT_TRUE(contains(small, "0.009 x 0.005 x 0.005 m")) << small;
  EXPECT_TRUE(contains(small, "10 to 400 mm")) << small;
  const std::string large = complaint(file_of(box_mesh({0.41, 0.1, 0.1})));
  EXPECT_TRUE(contains(large, "0.41 x 0.1 x 0.1 m")) << large;
  EXPECT_FALSE(contains(large, "millimetres")) << large;
  const std::string millimetres = complaint(file_of(box_mesh({50, 94, 175})));
  EXPECT_TRUE(contains(millimetres, "50 x 94 x 175 m")) << millimetres;
  EXPECT_TRUE(contains(millimetres, "millimetres")) << millimetres;
  EXPECT_EQ(complaint(file_of(box_mesh({0.4, 0.1, 0.1}))), "accepted");
  TriangleMesh with_stray = box_mesh({0.05, 0.1, 0.2});
  with_stray.vertices.emplace_back(100, 0, 0);  // of no triangle
  EXPECT_EQ(complaint(file_of(with_stray)), "accepted");
}

TEST_F(KnownObjectFile, ASizeAfterItsNameIsThatOfALargerOrSmallerMesh) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(0.05, -0.02, 0.1);
  const TriangleMesh mesh = transformed(T, bracket_mesh());
  TriangleMesh larger = mesh;
  for (auto& vertex : larger.vertices) vertex *= 1.2;
  const KnownObject made = make_known_object("thing", larger, 0);
  const KnownObject resized = load_known_object(file_of(mesh) + "@1.2");
  EXPECT_EQ(resized.name, "thing");
  EXPECT_EQ(resized.size, 1.2);
  EXPECT_LT((resized.T_mesh_object.matrix() - made.T_mesh_object.matrix()).norm(), 1e-9);
  EXPECT_LT((bounds(resized.mesh).sizes() - bounds(made.mesh).sizes()).norm(), 1e-9);
  EXPECT_NEAR(resized.mass_properties.volume, made.mass_properties.volume, 1e-12);
  EXPECT_EQ(resized.symmetries.size(), made.symmetries.size());
  ASSERT_EQ(resized.stable_poses.size(), made.stable_poses.size());
  EXPECT_NEAR(resized.stable_poses[0].height, made.stable_poses[0].height, 1e-6);
  EXPECT_NEAR(resized.mass, 1.728 * load_known_object(file_of(mesh)).mass, 1e-9);
  EXPECT_TRUE(is_same_shape(resized, load_known_object(file_of(mesh))));
  EXPECT_FALSE(is_same_shape(resized, load_known_object("bracket")));
}

TEST_F(KnownObjectFile, WhatIsNoSizeStaysInTheName) {
  EXPECT_EQ(sized_name("mug@0.95").name, "mug");
  EXPECT_EQ(sized_name("mug@0.95").size, 0.95);
  EXPECT_EQ(sized_name("mug@1").name, "mug");
  EXPECT_EQ(sized_name("me@home").name, "me@home");
  EXPECT_EQ(sized_name("mug@0.95x").name, "mug@0.95x");
  const std::string file = file_of(bracket_mesh());
  const std::string with_at = file + "@2";
  std::filesystem::copy_file(file, with_at);
  EXPECT_EQ(sized_name(with_at).name, with_at);
  EXPECT_TRUE(contains(complaint("mug@0.01"), "0.01"));
  EXPECT_TRUE(contains(complaint("mug@nan"), "nan"));
  EXPECT_TRUE(contains(complaint("mug@9"), "10 to 400 mm"));
  EXPECT_TRUE(contains(complaint("mugg@0.9"), "did you mean 'mug'"));
}

TEST_F(KnownObjectFile, AMeshThatCannotBeRepairedIsNamed) {
  TriangleMesh triangle;
  triangle.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};
  triangle.triangles = {{0, 1, 2}};
  const std::string file = file_of(triangle);
  EXPECT_EQ(complaint(file), file + ": nothing of the mesh encloses a volume");
}

TEST_F(KnownObjectFile, DefectsAreRepairedAndReported) {
  TriangleMesh open = bottle_mesh();
  open.triangles.pop_back();
  const KnownObject object = load_known_object(file_of(open));
  EXPECT_TRUE(inspect(object.mesh).watertight);
  EXPECT_FALSE(object.repairs.empty());
  EXPECT_TRUE(load_known_object(file_of(bottle_mesh())).repairs.empty());
}

/// As a scanner leaves it.
TriangleMesh rough(TriangleMesh mesh) {
  RandomStream random(8);
  for (auto& vertex : mesh.vertices) vertex += 1e-4 * random.unit_vector();
  return mesh;
}

TEST_F(KnownObjectFile, ARoughScanHasTheSymmetriesOfWhatWasScanned) {
  for (const auto& [mesh, symmetries] :
       {std::pair(mug_mesh(), 1U), std::pair(box_mesh({0.05, 0.09, 0.17}), 4U)}) {
    const KnownObject object = load_known_object(file_of(rough(mesh)));
    EXPECT_EQ(object.symmetries.size(), symmetries);
    EXPECT_NEAR(object.mass_properties.volume, inspect(mesh).volume, 0.02 * inspect(mesh).volume);
  }
}

void expect_mug(const KnownObject& mug) {
  EXPECT_EQ(mug.symmetries.size(), 1u);
  EXPECT_EQ(mug.stable_poses.size(), 4u);
  EXPECT_NEAR(mug.mass, 300 * mug.mass_properties.volume, 0.02);
}

void expect_oval_bottle(const KnownObject& bottle, std::size_t stable_poses) {
  EXPECT_EQ(bottle.symmetries.size(), 2u);
  EXPECT_GE(bottle.stable_poses.size(), stable_poses);
}

TEST_F(KnownObjectFile, ScannedMugAndBottle) {
  expect_mug(load_known_object(file_of(rough(mug_mesh()))));
  expect_oval_bottle(load_known_object(file_of(rough(bottle_mesh()))), 3);  // stands, lies
  if (const auto mug = real_data("ycb/025_mug.ply")) expect_mug(load_known_object(mug->string()));
  if (const auto mustard = real_data("ycb/006_mustard_bottle.ply")) {
    expect_oval_bottle(load_known_object(mustard->string()), 4);
  }
}

}  // namespace
}  // namespace palpate::geometry
