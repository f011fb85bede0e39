// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/quadratic_form.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "palpate/core/error.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using testing::make_problem;
using testing::random_pose;

testing::Problem noisy_problem(std::size_t pairs, std::uint64_t seed) {
  return make_problem({.pairs = pairs, .noise = 0.002, .normal_deg = 5, .normals = true},
                      RandomStream(seed, "form"));
}

std::vector<double> random_weights(std::size_t count, RandomStream& random) {
  std::vector<double> weights(count);
  for (double& w : weights) w = random.uniform();
  return weights;
}

double weighted_sum(const std::vector<double>& squared, const std::vector<double>& weights) {
  double sum = 0;
  for (std::size_t i = 0; i < squared.size(); ++i) sum += weights[i] * squared[i];
  return sum;
}

TEST(QuadraticForm, IsTheSumOfSquaredResidualsAtEveryPose) {
  RandomStream random(1, "form");
  for (const Primitive primitive : {Primitive::kPoint, Primitive::kPlane}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const auto problem = noisy_problem(3 + 5 * seed, seed);
      const auto weights = random_weights(problem.correspondences.size(), random);
      const Matrix13d M = quadratic_form(problem.correspondences, weights, primitive);
      const Eigen::Isometry3d T = random_pose(random);
      const double expected =
          weighted_sum(squared_residuals(problem.correspondences, T, primitive), weights);
      const Vector13d tau = homogeneous(T);
      EXPECT_NEAR(tau.dot(M * tau), expected, 1e-12 * M.trace());
      EXPECT_TRUE(M.isApprox(M.transpose()));
    }
  }
}

TEST(QuadraticForm, MarginalIsTheLeastOverTheTranslation) {
  RandomStream random(2, "form");
  for (const Primitive primitive : {Primitive::kPoint, Primitive::kPlane}) {
    const auto problem = noisy_problem(40, 3);
    const Matrix13d M = quadratic_form(problem.correspondences, {}, primitive);
    const MarginalForm marginal = marginalize(M);
    for (int k = 0; k < 20; ++k) {
      Eigen::Isometry3d T = random_pose(random);
      const Vector10d r = homogeneous(Eigen::Matrix3d(T.linear()));
      T.translation() = marginal.translation * r;
      const double least = homogeneous(T).dot(M * homogeneous(T));
      EXPECT_NEAR(r.dot(marginal.objective * r), least, 1e-12 * M.trace());
      T.translation() += 0.01 * random.unit_vector();
      EXPECT_GT(homogeneous(T).dot(M * homogeneous(T)), least);
    }
  }
}

TEST(QuadraticForm, MarginalOfOnePlaneIsFinite) {
  auto problem = noisy_problem(10, 4);
  for (auto& n : problem.correspondences.target_normals) n = Eigen::Vector3d::UnitZ();
  const MarginalForm marginal =
      marginalize(quadratic_form(problem.correspondences, {}, Primitive::kPlane));
  EXPECT_TRUE(marginal.objective.allFinite());
  EXPECT_TRUE(marginal.translation.topRows<2>().isZero(1e-12));
}

TEST(QuadraticForm, OriginsKeepTheDigitsOfFarCoordinates) {
  RandomStream random(5, "form");
  auto problem = noisy_problem(30, 5);
  const MarginalForm near =
      marginalize(quadratic_form(problem.correspondences, {}, Primitive::kPoint));
  const Eigen::Vector3d far(1e6, -2e6, 3e6);
  for (auto& p : problem.correspondences.source) p += far;
  for (auto& p : problem.correspondences.target) p -= far;
  const Origins origins = weighted_means(problem.correspondences, {});
  const MarginalForm moved =
      marginalize(quadratic_form(problem.correspondences, {}, Primitive::kPoint, origins));
  EXPECT_LT((moved.objective - near.objective).norm(), 1e-6 * near.objective.norm());
}

TEST(Information, IsTheCurvatureOfTheCost) {
  RandomStream random(6, "form");
  for (const Primitive primitive : {Primitive::kPoint, Primitive::kPlane}) {
    // Without noise the residuals vanish and their curvature drops out.
    const auto problem = make_problem({.pairs = 25, .normals = true}, RandomStream(6, "exact"));
    const auto weights = random_weights(25, random);
    const Eigen::Vector3d center = random.normal3();
    const Matrix6d information =
        information_matrix(problem.correspondences, weights, primitive, problem.truth, center);
    Eigen::Isometry3d shift = Eigen::Isometry3d::Identity();
    shift.translation() = center;
    for (int k = 0; k < 10; ++k) {
      const Vector6d twist = 1e-5 * Vector6d::NullaryExpr([&] { return random.normal(); });
      const Eigen::Isometry3d T = shift * exp_se3(twist) * shift.inverse() * problem.truth;
      const double cost =
          weighted_sum(squared_residuals(problem.correspondences, T, primitive), weights);
      EXPECT_NEAR(cost / twist.dot(information * twist), 1, 1e-3);
    }
  }
}

TEST(Correspondences, BadInputNamesTheValue) {
  const auto good = noisy_problem(5, 7).correspondences;
  auto bad = good;
  bad.target.pop_back();
  EXPECT_THROW(check(bad), BadInput);
  bad = good;
  bad.source[2][1] = std::numeric_limits<double>::quiet_NaN();
  try {
    check(bad);
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("source point 2"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("nan"), std::string::npos);
  }
  bad = good;
  bad.target[0][0] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(check(bad), BadInput);
  bad = good;
  bad.target_normals[1] *= 1.1;
  EXPECT_THROW(check(bad), BadInput);
  bad = good;
  bad.target_normals.clear();
  EXPECT_NO_THROW(check(bad, Primitive::kPoint));
  EXPECT_THROW(check(bad, Primitive::kPlane), BadInput);
}

TEST(Correspondences, AreReadFromBuffers) {
  const float rows[] = {1, 2, 3, 4, 5, 6, 7, 8};
  const Correspondences pairs =
      paired({rows, 2, 4 * sizeof(float)}, {rows + 1, 2, 4 * sizeof(float)});
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs.source[1], Eigen::Vector3d(5, 6, 7));
  EXPECT_EQ(pairs.target[0], Eigen::Vector3d(2, 3, 4));
  EXPECT_FALSE(pairs.has_normals());
  EXPECT_THROW(paired({rows, 2}, {rows, 1}), BadInput);
}

}  // namespace
}  // namespace palpate::registration
