// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/tactile/sensors/height_map.hpp"
#include "palpate/tactile/sensors/intrinsic_contact.hpp"
#include "palpate/tactile/sensors/taxel_array.hpp"
#include "palpate/tactile/sensors/taxel_layout.hpp"

namespace palpate::tactile {
namespace {

Eigen::Isometry3d any_pose(std::uint64_t seed) {
  RandomStream random(seed, "pose");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = random.rotation();
  T.translation() = 0.1 * random.normal3();
  return T;
}

/// A ball of radius 20 mm pressed 1 mm into the gel.
HeightMap ball_print(double radius, double press) {
  HeightMap map{Eigen::MatrixXd::Zero(240, 320), 0.00005};
  for (Eigen::Index i = 0; i < 240; ++i) {
    for (Eigen::Index j = 0; j < 320; ++j) {
      const double x = (static_cast<double>(j) - 159.5) * map.pixel;
      const double y = (static_cast<double>(i) - 119.5) * map.pixel;
      const double height = radius - std::sqrt(radius * radius - x * x - y * y);
      map.depth(i, j) = std::max(0.0, press - height);
    }
  }
  return map;
}

TEST(HeightMap, GivesPointsAndNormalsOfABall) {
  const double radius = 0.02, press = 0.001;
  const Eigen::Isometry3d T = any_pose(1);
  const auto contacts = contacts_of_height_map(ball_print(radius, press), T);
  ASSERT_GT(contacts.size(), 20U);
  const Eigen::Vector3d center = T * Eigen::Vector3d(0, 0, radius - press);
  for (const Contact& contact : contacts) {
    const Eigen::Vector3d arm = contact.p - center;
    EXPECT_NEAR(arm.norm(), radius, 3e-5);
    EXPECT_GT(contact.n.dot(arm.normalized()), std::cos(0.01));
  }
}

TEST(HeightMap, RefusesWhatIsNone) {
  HeightMap map = ball_print(0.02, 0.001);
  EXPECT_TRUE(contacts_of_height_map({Eigen::MatrixXd::Zero(64, 64), 1e-4}, any_pose(2)).empty());
  map.pixel = 0;
  EXPECT_THROW(contacts_of_height_map(map, any_pose(2)), BadInput);
  map.pixel = 1e-4;
  map.depth(3, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(contacts_of_height_map(map, any_pose(2)), BadInput);
  EXPECT_THROW(contacts_of_height_map({}, any_pose(2)), BadInput);
  const Eigen::MatrixXd millimetres = 1000 * ball_print(0.02, 0.001).depth;
  EXPECT_THROW(contacts_of_height_map({millimetres, 0.00005}, any_pose(2)), BadInput);
}

TEST(TaxelLayout, GivesForcesOfRawValues) {
  const auto layout = parse_taxel_layout(
      "finger,x,y,z,nx,ny,nz,gain,zero\nTH,0.01,0,0,2,0,0,0.01,50\nTH,0,0,0,0,1,0,,\nFF,0,0,0,0,0,"
      "1,1,0\n",
      "skin.csv");
  ASSERT_EQ(layout.size(), 2U);
  const auto& thumb = layout.at("TH");
  const std::vector<double> values = {150, 0.01};
  const auto contacts = contacts_of_values(thumb, values);
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_EQ(contacts[0].n, Eigen::Vector3d(-1, 0, 0));
  EXPECT_NEAR(contacts[0].f.x(), 1, 1e-12);
  EXPECT_THROW(contacts_of_values(thumb, std::vector<double>{1}), BadInput);
  for (const char* bad :
       {"finger,x,y,z,nx,ny,nz\n", "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n",
        "finger,x,y,z,nx,ny,nz\nTH,0,0,0,0,0,0\n", "finger,x,y,z,nx,ny,nz\nTH,1e9,0,0,0,0,1\n"}) {
    EXPECT_THROW(parse_taxel_layout(bad, "skin.csv"), BadInput) << bad;
  }
}

TEST(Taxels, TouchWhereTheyAreLoaded) {
  const Eigen::Isometry3d T = any_pose(3);
  const Eigen::Vector3d n = Eigen::Vector3d::UnitX();
  const auto contacts = contacts_of_taxels({{{0, 0, 0}, n, 0.0}, {{0, 0.01, 0}, n, 0.5}}, T);
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_TRUE(contacts[0].p.isApprox(T * Eigen::Vector3d(0, 0.01, 0)));
  EXPECT_TRUE(contacts[0].n.isApprox(-T.linear() * n));
  EXPECT_NEAR(contacts[0].f.dot(contacts[0].n), -0.5, 1e-12);
  EXPECT_THROW(contacts_of_taxels({{{0, 0, 0}, 2 * n, 0.5}}, T), BadInput);
}

/// Bicchi's test: the wrench of a random point contact with friction leads back to its point.
TEST(IntrinsicContact, LeadsBackToThePointOfAWrench) {
  const FingertipCapsule tip{{0, 0, 0.005}, {0, 0, 0.02}, 0.008};
  RandomStream random(4, "intrinsic");
  const Eigen::Isometry3d T = any_pose(4);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d skin = random.unit_vector();
    const Eigen::Vector3d end = skin.z() < 0 ? tip.a : tip.b;
    const Eigen::Vector3d p = end + tip.radius * skin;
    const Eigen::Vector3d f = -2 * (skin + 0.3 * random.unit_vector()).normalized();
    const auto contact = contact_of_wrench({f, p.cross(f)}, tip, T);
    ASSERT_TRUE(contact) << i;
    EXPECT_LT((contact->p - T * p).norm(), 1e-9) << i;
    EXPECT_LT((contact->n + T.linear() * skin).norm(), 1e-6) << i;
    EXPECT_LT(contact->f.dot(contact->n), 0);
  }
}

TEST(IntrinsicContact, SaysWhereThereIsNone) {
  const FingertipCapsule tip{{0, 0, 0}, {0, 0, 0}, 0.01};
  const Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  EXPECT_FALSE(contact_of_wrench({{0, 0, 0.01}, {0, 0, 0}}, tip, T));
  EXPECT_FALSE(contact_of_wrench({{0, 0, 1}, {0.05, 0, 0}}, tip, T));  // passes 50 mm beside it
  EXPECT_THROW(contact_of_wrench({{0, 0, 1}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}, 0}, T), BadInput);
}

}  // namespace
}  // namespace palpate::tactile
