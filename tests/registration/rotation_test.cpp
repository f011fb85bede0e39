// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/rotation.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/registration/pose.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using testing::make_problem;

Matrix10d objective_of(const testing::Problem& problem, Primitive primitive) {
  return marginalize(quadratic_form(problem.correspondences, {}, primitive,
                                    weighted_means(problem.correspondences, {})))
      .objective;
}

Matrix10d plane_objective(std::size_t pairs, double noise, std::uint64_t seed) {
  return objective_of(make_problem({.pairs = pairs, .noise = noise}, RandomStream(seed, "plane")),
                      Primitive::kPlane);
}

double cost_of(const Matrix10d& objective, const Eigen::Matrix3d& R) {
  return homogeneous(R).dot(objective * homogeneous(R));
}

double scale_of(const Matrix10d& objective) { return objective.trace() / 10; }

TEST(Rotation, FindsTheExactRotation) {
  for (const Primitive primitive : {Primitive::kPoint, Primitive::kPlane}) {
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
      const auto problem = make_problem({.pairs = 12}, RandomStream(seed, "exact"));
      const RotationEstimate estimate = solve_rotation(objective_of(problem, primitive));
      EXPECT_TRUE(estimate.certificate.certified);
      EXPECT_LT(rotation_distance(estimate.R, problem.truth.linear()), 1e-6) << seed;
    }
  }
}

TEST(Rotation, AgreesWithTheClosedFormForPoints) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto problem =
        make_problem({.pairs = 4 + seed, .noise = 0.02}, RandomStream(seed, "closed"));
    const RotationEstimate estimate = solve_rotation(objective_of(problem, Primitive::kPoint));
    const auto closed = align_points(problem.correspondences, {});
    EXPECT_TRUE(estimate.certificate.certified) << seed;
    EXPECT_LT(rotation_distance(estimate.R, closed.linear()), 1e-6) << seed;
  }
}

TEST(Rotation, CertifiesEverySolvableProblem) {
  for (const std::size_t pairs : {7u, 8u, 10u, 20u, 50u}) {
    for (const double noise : {0.0, 0.001, 0.01}) {
      for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const RotationEstimate estimate = solve_rotation(plane_objective(pairs, noise, seed));
        EXPECT_TRUE(estimate.certificate.certified) << pairs << " " << noise << " " << seed;
      }
    }
  }
}

TEST(Rotation, NeverCertifiesAWrongMinimum) {
  RandomStream random(1, "wrong");
  int wrong = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Matrix10d objective = plane_objective(8 + seed % 5, 0.005, seed);
    const double scale = scale_of(objective);
    const double least = cost_of(objective, solve_rotation(objective).R);
    for (int k = 0; k < 20; ++k) {
      const Eigen::Matrix3d R = refine_rotation(objective, random.rotation());
      const double cost = cost_of(objective, R);
      EXPECT_GE(cost, least - 1e-6 * std::max(least, scale));
      if (cost < least + 1e-5 * scale) continue;
      const RotationCertificate certificate = certify_rotation(objective, R);
      EXPECT_FALSE(certificate.certified);
      EXPECT_GE(certificate.bound, cost - least - 1e-6 * std::max(least, scale));
      ++wrong;
    }
  }
  EXPECT_GT(wrong, 100);
}

TEST(Rotation, BoundHoldsForAnyRotation) {
  RandomStream random(2, "bound");
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Matrix10d objective = plane_objective(15, 0.003, seed);
    const Eigen::Matrix3d best = solve_rotation(objective).R;
    for (const double angle : {1e-5, 1e-3, 0.02, 0.5, 3.0}) {
      const Eigen::Matrix3d R = best * exp_so3(angle * random.unit_vector());
      const RotationCertificate certificate = certify_rotation(objective, R);
      const double excess = cost_of(objective, R) - cost_of(objective, best);
      EXPECT_GE(certificate.bound, excess - 1e-12 * scale_of(objective));
      EXPECT_TRUE(angle < 0.02 || !certificate.certified);
    }
  }
}

// Forms of no registration problem, for which the dual may not be tight.
TEST(Rotation, BoundHoldsForAnyForm) {
  RandomStream random(3, "any");
  int uncertified = 0;
  for (int k = 0; k < 60; ++k) {
    const int rank = 1 + k % 10;
    Eigen::MatrixXd factor(10, rank);
    for (double& value : factor.reshaped()) value = random.normal();
    const Matrix10d objective = factor * factor.transpose();
    const RotationEstimate estimate = solve_rotation(objective);
    uncertified += !estimate.certificate.certified;
    for (int j = 0; j < 30; ++j) {
      const double other = cost_of(objective, refine_rotation(objective, random.rotation()));
      EXPECT_GE(other, estimate.certificate.cost - estimate.certificate.bound - 1e-9);
    }
  }
  EXPECT_LE(uncertified, 6);
}

TEST(Rotation, CertificateDoesNotDependOnScale) {
  const Matrix10d objective = plane_objective(30, 0.001, 1);
  const RotationEstimate estimate = solve_rotation(objective);
  for (const double factor : {1e-12, 1e12}) {
    const RotationEstimate scaled = solve_rotation(factor * objective);
    EXPECT_TRUE(scaled.certificate.certified);
    EXPECT_LT(rotation_distance(scaled.R, estimate.R), 1e-6);
    EXPECT_NEAR(scaled.certificate.cost / factor, estimate.certificate.cost,
                1e-9 * scale_of(objective));
  }
}

TEST(Rotation, RefusesWhatIsNotFiniteOrNoRotation) {
  Matrix10d objective = plane_objective(30, 0.001, 1);
  const Eigen::Matrix3d bad = Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(certify_rotation(objective, bad), BadInput);
  EXPECT_THROW(certify_rotation(objective, -Eigen::Matrix3d::Identity()), BadInput);
  EXPECT_THROW(certify_rotation(objective, 2 * Eigen::Matrix3d::Identity()), BadInput);
  objective(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(solve_rotation(objective), BadInput);
}

}  // namespace
}  // namespace palpate::registration
