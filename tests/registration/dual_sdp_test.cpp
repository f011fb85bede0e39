// SPDX-License-Identifier: Apache-2.0
#include "registration/dual_sdp.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/registration/rotation.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

Matrix10d objective_of(std::size_t pairs, double noise, Primitive primitive, std::uint64_t seed) {
  const auto c = testing::make_problem({.pairs = pairs, .noise = noise}, RandomStream(seed, "dual"))
                     .correspondences;
  return marginalize(quadratic_form(c, {}, primitive, weighted_means(c, {}))).objective;
}

double cost_of(const Matrix10d& objective, const Eigen::Matrix3d& R) {
  return homogeneous(R).dot(objective * homogeneous(R));
}

TEST(Dual, AgreesWithTheFastSolve) {
  for (const Primitive primitive : {Primitive::kPoint, Primitive::kPlane}) {
    for (const std::size_t pairs : {7u, 10u, 30u, 300u}) {
      for (const double noise : {0.0, 0.001, 0.01}) {
        for (std::uint64_t seed = 0; seed < 10; ++seed) {
          const Matrix10d objective = objective_of(pairs, noise, primitive, seed);
          const DualSolution dual = solve_dual(objective);
          const RotationEstimate fast = solve_rotation(objective);
          const double least = fast.certificate.cost;
          const double reference = std::max(least, objective.trace() / 10);
          EXPECT_TRUE(dual.converged);
          EXPECT_NEAR(dual.value, least, 1e-6 * reference);
          EXPECT_LE(dual.value, least + 1e-12 * reference);
          EXPECT_GE(dual.value + dual.gap, least - fast.certificate.bound - 1e-12 * reference);
        }
      }
    }
  }
}

TEST(Dual, ItsNullSpaceIsTheRotation) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Matrix10d objective = objective_of(30, 0.002, Primitive::kPlane, seed);
    EXPECT_LT(rotation_distance(solve_dual(objective).R, solve_rotation(objective).R), 1e-3);
  }
}

TEST(Dual, ValueIsALowerBoundForEveryRotation) {
  RandomStream random(1, "dual");
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Matrix10d objective = objective_of(10, 0.005, Primitive::kPlane, seed);
    const DualSolution dual = solve_dual(objective, 1e-4);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix10d>(dual.Z).eigenvalues()[0], 0);
    for (int k = 0; k < 50; ++k) {
      const Eigen::Matrix3d R = refine_rotation(objective, random.rotation());
      EXPECT_LE(dual.value, cost_of(objective, R));
      // On SO(3) the penalty is the value itself (thesis eq. 6.29).
      const Vector10d r = homogeneous(R);
      EXPECT_NEAR(r.dot(dual.Z * r) + dual.value, cost_of(objective, R), 1e-9 * objective.trace());
    }
  }
}

TEST(Dual, BadInput) {
  Matrix10d objective = objective_of(10, 0.001, Primitive::kPoint, 1);
  EXPECT_THROW(solve_dual(objective, 0), BadInput);
  objective(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(solve_dual(objective), BadInput);
}

}  // namespace
}  // namespace palpate::registration
