// SPDX-License-Identifier: Apache-2.0
#include "normal_clusters.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::tactile {
namespace {

Eigen::Vector3d noisy(const Eigen::Vector3d& n, double sigma, RandomStream& random) {
  return (n + sigma * random.normal3()).normalized();
}

/// Ten ticks of two contacts, one on each face of an edge.
std::vector<NormalAt> on_an_edge(std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<NormalAt> contacts;
  for (int tick = 0; tick < 10; ++tick) {
    for (const Eigen::Vector3d& n : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, 1)}) {
      contacts.push_back({0.002 * n + 0.0005 * random.normal3(), noisy(n, 0.1, random)});
    }
  }
  return contacts;
}

TEST(ClusterNormals, AnEdgeGivesItsTwoFacesAndNotTheirMean) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto clusters = cluster_normals(on_an_edge(seed));
    ASSERT_EQ(clusters.size(), 2u) << seed;
    EXPECT_EQ(clusters[0].size + clusters[1].size, 20u);
    for (const auto& cluster : clusters) EXPECT_GT(cluster.n.maxCoeff(), std::cos(0.15));
  }
}

TEST(ClusterNormals, ByPlaceAloneTheyAreOne) {
  const auto clusters = cluster_normals(on_an_edge(1), {.angle = std::numbers::pi});
  ASSERT_EQ(clusters.size(), 1u);
  EXPECT_GT(clusters[0].n.dot(Eigen::Vector3d(1, 0, 1).normalized()), std::cos(0.15));
}

TEST(ClusterNormals, NormalsTurnedRoundStayApart) {
  std::vector<NormalAt> contacts(10, {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()});
  for (std::size_t i = 0; i < 4; ++i) contacts[i].n *= -1;
  const auto clusters = cluster_normals(contacts);
  ASSERT_EQ(clusters.size(), 2u);
  EXPECT_EQ(clusters[0].size, 6u);
  EXPECT_TRUE(clusters[0].n.isApprox(Eigen::Vector3d::UnitZ()));
}

TEST(ClusterNormals, PlacesACentimetreApartAreTwoAndChainsAreOne) {
  std::vector<NormalAt> contacts;
  for (int i = 0; i < 5; ++i) contacts.push_back({{0.009 * i, 0, 0}, {0, 0, 1}});
  EXPECT_EQ(cluster_normals(contacts).size(), 1u);
  for (int i = 0; i < 3; ++i) contacts.push_back({{0.047 + 0.001 * i, 0, 0}, {0, 0, 1}});
  EXPECT_EQ(cluster_normals(contacts).size(), 2u);
}

TEST(ClusterNormals, FewerThanThreeAreNone) {
  const std::vector<NormalAt> two(2, {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()});
  EXPECT_TRUE(cluster_normals(two).empty());
  EXPECT_TRUE(cluster_normals({}).empty());
}

TEST(ClusterNormals, RefusesContactsThatAreNotSoundAndOptionsOutOfRange) {
  std::vector<NormalAt> contacts(3, {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()});
  EXPECT_THROW(cluster_normals(contacts, {.distance = -1}), BadInput);
  EXPECT_THROW(find_faces(contacts, {.radius = std::numeric_limits<double>::quiet_NaN()}),
               BadInput);
  contacts[2].n.setZero();
  EXPECT_THROW(cluster_normals(contacts), BadInput);
  contacts[2].n = Eigen::Vector3d::UnitZ();
  contacts[1].p.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(cluster_normals(contacts), BadInput);
}

/// The contact at a tick of a slide over the face through the origin with that normal, with noise.
NormalAt on_face(const Eigen::Vector3d& n, int tick, RandomStream& random) {
  const Eigen::Matrix3d R = frame_with_z(n);
  const Eigen::Vector3d p =
      0.01 * (std::sin(0.1 * tick) * R.col(0) + std::cos(0.07 * tick) * R.col(1));
  return {p + 0.001 * random.normal3(), noisy(n, 0.05, random)};
}

/// The same of a slide along the edge through the origin.
NormalAt on_edge(const Eigen::Vector3d& edge, const Eigen::Vector3d& n, int tick,
                 RandomStream& random) {
  return {0.01 * std::sin(0.1 * tick) * edge + 0.001 * random.normal3(), noisy(n, 0.05, random)};
}

TEST(FindFaces, FindsTheFacesOfACornerAnyWayItIsTurned) {
  RandomStream random(4);
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Matrix3d R = random.rotation();
    std::vector<NormalAt> contacts;
    for (int i = 0; i < 900; ++i) contacts.push_back(on_face(R.col(i / 300), i, random));
    for (int i = 0; i < 100; ++i) {  // on the way round the edges
      const double angle = 1.57 * random.uniform();
      contacts.push_back(on_edge(
          R.col((i + 2) % 3), std::cos(angle) * R.col(i % 3) + std::sin(angle) * R.col((i + 1) % 3),
          i, random));
    }
    const auto faces = find_faces(contacts);
    ASSERT_EQ(faces.size(), 3u);
    for (const Face& face : faces) {
      EXPECT_GT((R.transpose() * face.n).maxCoeff(), std::cos(0.02));
      // Of 30 %, those within two standard deviations: 1 - exp(-2).
      EXPECT_NEAR(face.share, 0.26, 0.04);
    }
  }
}

TEST(FindFaces, ATipThatRestsOnAnEdgeIsOnNoFace) {
  RandomStream random(6);
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ();
  std::vector<NormalAt> contacts;
  for (int i = 0; i < 200; ++i) contacts.push_back(on_face(z, i, random));
  // For longer than on either face, between them, and a little aside of the second.
  for (int i = 0; i < 300; ++i)
    contacts.push_back(on_edge(y, (x + 0.5 * z).normalized(), i, random));
  for (int i = 0; i < 200; ++i) contacts.push_back(on_face(x, i, random));
  const auto faces = find_faces(contacts);
  ASSERT_EQ(faces.size(), 2u);
  for (const Face& face : faces) EXPECT_GT(face.n.maxCoeff(), std::cos(0.05));
}

TEST(FindFaces, OneFaceIsOneAndNoneIsNone) {
  RandomStream random(5);
  std::vector<NormalAt> contacts;
  for (int i = 0; i < 300; ++i) contacts.push_back(on_face({0, 1, 0}, i, random));
  EXPECT_EQ(find_faces(contacts).size(), 1u);
  EXPECT_TRUE(find_faces({}).empty());
  contacts[7].n.setConstant(std::numeric_limits<double>::infinity());
  EXPECT_THROW(find_faces(contacts), BadInput);
}

}  // namespace
}  // namespace palpate::tactile
