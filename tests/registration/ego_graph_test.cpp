// SPDX-License-Identifier: Apache-2.0
#include "registration/ego_graph.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "consistency_graph.hpp"
#include "registration/nearest_rotation.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using testing::make_problem;

constexpr double kBound = 0.004;

TEST(EgoGraph, IsTheGraphAboutOneVertex) {
  for (const bool normals : {false, true}) {
    const auto problem = make_problem(
        {.pairs = 150, .outliers = 0.7, .noise = 0.001, .normal_deg = 5, .normals = normals},
        RandomStream(2, "star"));
    const double noise_deg = normals ? 5 : 0;
    const auto& c = problem.correspondences;
    const ConsistencyGraph graph(c, {.noise_bound = kBound, .normal_noise_deg = noise_deg});
    const PairColumns columns = columns_of(c, c.source[0], c.target[0], kBound, normals);
    EgoGraph ego(columns, ConsistencyOptions{}.length_tolerance, noise_deg);
    for (int center = 0; center < graph.size(); ++center) {
      ego.look_around(center);
      EXPECT_EQ(static_cast<int>(ego.neighbours().size()), graph.degree(center));
      for (const int other : ego.neighbours()) EXPECT_TRUE(graph.joined(center, other));
      const auto clique = ego.clique(16);
      EXPECT_EQ(clique, grow_clique(graph, center, 16));
    }
  }
}

TEST(RotationBetween, IsTheNearestRotation) {
  RandomStream random(7, "rotation");
  for (int run = 0; run < 500; ++run) {
    const Eigen::Matrix3d R = random.rotation();
    const double scale = std::pow(10.0, random.uniform(-3, 3));
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double squares = 0;
    for (int i = 0; i < 3 + run % 5; ++i) {
      const Eigen::Vector3d p = scale * random.normal3();
      const Eigen::Vector3d q = R * p + 0.05 * scale * random.normal3();
      covariance += q * p.transpose();
      squares += q.squaredNorm() + p.squaredNorm();
    }
    const Eigen::Matrix3d found = rotation_between(covariance, 0.5 * squares);
    EXPECT_LT((found * found.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
    // As good as the singular vectors' (a mirrored cloud has two nearly alike).
    EXPECT_GE((found.transpose() * covariance).trace(),
              (nearest_rotation(covariance).transpose() * covariance).trace() - 1e-6 * squares);
  }
}

TEST(RotationBetween, DegenerateSetsGiveARotation) {
  const Eigen::Matrix3d nothing = Eigen::Matrix3d::Zero();
  EXPECT_NEAR(rotation_between(nothing, 0).determinant(), 1, 1e-9);
  const Eigen::Vector3d p(1, 2, 3), q(3, 2, -1);  // a line: any turn about it is as good
  const Eigen::Matrix3d line = q * p.transpose();
  const Eigen::Matrix3d R = rotation_between(line, 14);
  EXPECT_NEAR(R.determinant(), 1, 1e-9);
  EXPECT_LT((R * p - q).norm(), 1e-6);
  const Eigen::Matrix3d mirror = -Eigen::Matrix3d::Identity();
  EXPECT_NEAR(rotation_between(mirror, 3).determinant(), 1, 1e-9);
}

}  // namespace
}  // namespace palpate::registration
