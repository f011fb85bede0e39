// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/drawn_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/shadow.hpp"
#include "simulation/scenes.hpp"

namespace palpate::simulation {
namespace {

TEST(DifferingObject, IsNominalWhereNothingDiffers) {
  const auto nominal = geometry::load_known_object("bracket");
  const SolidObject solid = differing_object(believed_object(nominal), {}, RandomStream(1));
  EXPECT_EQ(solid.object.mesh.vertices, nominal.mesh.vertices);
  EXPECT_EQ(solid.object.mass, nominal.mass);
  EXPECT_FALSE(solid.parts.empty());
}

TEST(DifferingObject, IsDentedByAsMuchAsIsAskedAndNotMoved) {
  const auto nominal = geometry::load_known_object("bottle");
  double square = 0;
  constexpr int kObjects = 20;
  for (int seed = 0; seed < kObjects; ++seed) {
    const SolidObject solid = differing_object(believed_object(nominal), {.surface = 0.0005},
                                               RandomStream(static_cast<unsigned>(seed)));
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double sum = 0;
    for (std::size_t i = 0; i < nominal.mesh.vertices.size(); ++i) {
      const Eigen::Vector3d way = solid.object.mesh.vertices[i] - nominal.mesh.vertices[i];
      mean += way / static_cast<double>(nominal.mesh.vertices.size());
      sum += way.squaredNorm() / static_cast<double>(nominal.mesh.vertices.size());
    }
    square += sum / kObjects;
    EXPECT_LT(mean.norm(), 0.0004) << "aligned with what it shows";
  }
  // What moves the surface as a whole is taken off, up to a half of the long waves.
  EXPECT_GT(std::sqrt(square), 0.0002);
  EXPECT_LT(std::sqrt(square), 0.0006);
}

TEST(DifferingObject, HasAnotherSizeAndMassWithinTheBounds) {
  const auto nominal = geometry::load_known_object("box");
  for (unsigned seed = 0; seed < 20; ++seed) {
    const WorldErrors error{.mass = 0.2, .scale = 0.01};
    const SolidObject solid = differing_object(believed_object(nominal), error, RandomStream(seed));
    EXPECT_NEAR(solid.object.mass / nominal.mass, 1, 0.2);
    EXPECT_NE(solid.object.mass, nominal.mass);
    const double scale = solid.object.mesh.vertices[0].norm() / nominal.mesh.vertices[0].norm();
    EXPECT_NEAR(scale, 1, 0.01 + 1e-12);
    EXPECT_NE(scale, 1);
  }
}

TEST(RealisticWorld, AnObjectRestsOnItsTiltedTable) {
  const auto object = geometry::load_known_object("box");
  WorldOptions options = without_noise();
  options.error.table_tilt = 0.05;
  World world(object, options, 11);
  world.reset({}, open_hand(0.4));
  for (int i = 0; i < 100; ++i) world.hand().step(open_hand(0.4));
  const Truth truth = world.truth();
  EXPECT_GT(std::acos(truth.T_world_table.linear()(2, 2)), 1e-4);
  EXPECT_NEAR(truth.lowest_point, 0, 5e-4);
  const Eigen::Vector3d up = truth.T_world_table.linear().col(2);
  const Eigen::Vector3d face =
      truth.T_world_object.linear() * object.stable_poses[0].R_table_object.transpose().col(2);
  EXPECT_LT(std::acos(std::min(1.0, face.dot(up))), 0.005);
}

TEST(RealisticWorld, TheLoadIsReadWithItsBias) {
  const auto object = geometry::load_known_object("box");
  WorldOptions options = without_noise();
  World exact(object, options, 5);
  options.error.load_bias = 0.3;
  World biased(object, options, 5);
  exact.reset({}, open_hand(0.4));
  biased.reset({}, open_hand(0.4));
  const Eigen::Vector3d apart = biased.hand().step(open_hand(0.4)).mount_force -
                                exact.hand().step(open_hand(0.4)).mount_force;
  EXPECT_GT(apart.norm(), 0.02);
  EXPECT_LT(apart.norm(), 1.2);
}

TEST(RealisticWorld, TheArmDoesNotKnowHowHighTheTableIs) {
  const auto object = geometry::load_known_object("box");
  WorldOptions options = without_noise();
  options.error.table_height = 0.005;
  World world(object, options, 6);
  world.reset({}, open_hand(0.4));
  hand::HandReading reading;
  for (int i = 0; i < 100; ++i) reading = world.hand().step(open_hand(0.4));
  EXPECT_NEAR(reading.mount.xyz.z(), 0.4, 1e-3) << "it reads what it was given";
}

TEST(RealisticWorld, ReadingsOfTheMountAreLate) {
  const auto object = geometry::load_known_object("box");
  WorldOptions options = without_noise();
  World prompt(object, options, 7);
  options.noise.mount_delay = 0.02;
  World late(object, options, 7);
  prompt.reset({}, open_hand(0.4));
  late.reset({}, open_hand(0.4));
  hand::HandCommand command = open_hand(0.4);
  std::vector<double> now, then;
  for (int i = 0; i < 20; ++i) {
    command.mount.xyz.x() += 0.001;
    now.push_back(prompt.hand().step(command).mount.xyz.x());
    then.push_back(late.hand().step(command).mount.xyz.x());
  }
  EXPECT_EQ(then[19], now[17]);
  EXPECT_NE(then[19], now[19]);
}

}  // namespace
}  // namespace palpate::simulation
