// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "palpate/registration/registration.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using testing::make_problem;
using testing::rotation_error_deg;

TEST(UnknownScale, OfTooLittle) {
  const RegistrationOptions options{.estimate_scale = true};
  auto problem = make_problem({.pairs = 3}, RandomStream(4, "register"));
  const auto three = register_correspondences(problem.correspondences, options);
  EXPECT_EQ(three.status, RegistrationStatus::kDegenerate);
  EXPECT_EQ(three.false_alarms, 1);
  // Half of the pairs on a line, so that chance does not explain them, and the others wrong.
  problem = make_problem({.pairs = 60}, RandomStream(6, "register"));
  RandomStream random(6, "line");
  for (std::size_t i = 0; i < 60; ++i) {
    problem.correspondences.source[i] = random.uniform(-0.1, 0.1) * Eigen::Vector3d::UnitX();
    problem.correspondences.target[i] = i % 2 ? Eigen::Vector3d(0.1 * random.normal3())
                                              : problem.truth * problem.correspondences.source[i];
  }
  problem.correspondences.target_normals.clear();
  EXPECT_EQ(register_correspondences(problem.correspondences, options).status,
            RegistrationStatus::kDegenerate);
}

// Further copies have the scale of the first one.
TEST(UnknownScale, OfSeveralInstances) {
  const auto one = make_problem({.pairs = 40, .noise = 0.0005}, RandomStream(7, "register"));
  const auto other = make_problem({.pairs = 30, .noise = 0.0005}, RandomStream(8, "register"));
  Correspondences pairs = subset(one.correspondences, {});
  for (const auto* problem : {&one, &other}) {
    const auto& c = problem->correspondences;
    pairs.source.insert(pairs.source.end(), c.source.begin(), c.source.end());
    pairs.target.insert(pairs.target.end(), c.target.begin(), c.target.end());
  }
  for (auto& p : pairs.source) p /= 2.5;
  const auto result = register_correspondences(
      pairs, {.estimate_scale = true, .instances = 3, .robust_bound = {.max_nodes = 1000}});
  ASSERT_TRUE(result.T_target_source);
  EXPECT_NEAR(result.scale, 2.5, 0.02);
  EXPECT_LT(rotation_error_deg(*result.T_target_source, one.truth), 1);
  ASSERT_EQ(result.instances.size(), 1);
  EXPECT_EQ(result.instances[0].inliers, 30);
  EXPECT_LT(rotation_error_deg(result.instances[0].T_target_source, other.truth), 1);
  ASSERT_TRUE(result.certificate.robust);
  EXPECT_GE(result.certificate.robust->max_inliers, 40);
}

// A little more scale moves points that lie far from the origin by much.
TEST(UnknownScale, OfFarCoordinates) {
  for (const double far : {0.0, 1e3, 1e7}) {
    auto problem =
        make_problem({.pairs = 100, .outliers = 0.5, .noise = 0.0005}, RandomStream(4, "register"));
    auto& c = problem.correspondences;
    for (auto& p : c.source) p = (p + far * Eigen::Vector3d(1, -2, 3)) / 1.72;
    for (auto& p : c.target) p -= far * Eigen::Vector3d(2, 1, 1);
    const auto result = register_correspondences(c, {.estimate_scale = true});
    ASSERT_TRUE(result.T_target_source) << far;
    EXPECT_NEAR(result.scale, 1.72, 0.003) << far;
    EXPECT_GE(result.inliers.size(), 50) << far;
  }
}

// A scale that is off by 1 % moves the points of a map of 400 m by a thousand noise bounds.
TEST(UnknownScale, OfWhatIsLargeForItsNoise) {
  for (const double size : {1.0, 1e2, 4e3}) {
    for (const double outliers : {0.3, 0.8}) {
      auto problem = make_problem({.pairs = 300, .outliers = outliers, .noise = 0.001 / size},
                                  RandomStream(4, "register"));
      for (auto& p : problem.correspondences.target) p *= size;
      const auto result =
          register_correspondences(problem.correspondences, {.estimate_scale = true});
      ASSERT_TRUE(result.T_target_source) << size << " " << outliers;
      EXPECT_NEAR(result.scale / size, 1, 0.05 / size) << outliers;
      EXPECT_LT(rotation_error_deg(*result.T_target_source, problem.truth), 1);
    }
  }
}

}  // namespace
}  // namespace palpate::registration
