// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "palpate/core/error.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/registration/registration.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using testing::make_problem;
using testing::Problem;
using testing::rotation_error_deg;
using testing::translation_error_mm;

/// A problem whose first wrong pairs agree on a second pose.
struct TwoPoses {
  Problem problem;
  Eigen::Isometry3d second = Eigen::Isometry3d::Identity();
};

TwoPoses two_poses(double first, double second, std::uint64_t seed) {
  TwoPoses result{make_problem({.outliers = 1 - first, .noise = 0.001}, RandomStream(seed, "two"))};
  RandomStream random(seed, "second");
  result.second = testing::random_pose(random);
  auto& c = result.problem.correspondences;
  auto left = static_cast<int>(second * static_cast<double>(c.size()));
  for (std::size_t i = 0; i < c.size() && left > 0; ++i) {
    if (result.problem.inlier[i]) continue;
    c.target[i] = result.second * c.source[i] + 0.001 * random.normal3();
    --left;
  }
  return result;
}

bool is_right(const Eigen::Isometry3d& T, const Eigen::Isometry3d& truth) {
  return rotation_error_deg(T, truth) < 5 && translation_error_mm(T, truth) < 10;
}

TEST(LargestConsensus, IsTheAnswerAndTheOtherTheRunnerUp) {
  int right = 0, runner_up = 0, runs = 0;
  for (const auto& [first, second] : {std::pair{0.7, 0.1}, {0.5, 0.25}, {0.1, 0.05}}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed, ++runs) {
      const auto [problem, other] = two_poses(first, second, seed);
      const auto result = register_correspondences(problem.correspondences);
      ASSERT_EQ(result.status, RegistrationStatus::kFound);
      right += is_right(*result.T_target_source, problem.truth);
      runner_up += result.runner_up && is_right(result.runner_up->T_target_source, other);
      if (!result.runner_up) continue;
      EXPECT_LT(result.runner_up->inliers, static_cast<int>(result.inliers.size()));
      EXPECT_LT(result.runner_up->false_alarms, 0.01);
    }
  }
  EXPECT_GE(right, runs - 1);  // a quarter was the smaller one before
  EXPECT_GE(runner_up, runs - 4);
}

TEST(LargestConsensus, SeveralInstancesOneAfterTheOther) {
  const auto [problem, other] = two_poses(0.5, 0.25, 3);
  const auto result = register_correspondences(problem.correspondences, {.instances = 4});
  ASSERT_TRUE(result.T_target_source);
  EXPECT_TRUE(is_right(*result.T_target_source, problem.truth));
  ASSERT_EQ(result.instances.size(), 1u);
  EXPECT_TRUE(is_right(result.instances[0].T_target_source, other));
  EXPECT_NEAR(result.instances[0].inliers, 250, 15);
}

// What noise put just beyond the bound came back as up to five poses a little off the first.
TEST(LargestConsensus, ALooseNoiseMakesNoFurtherInstances) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto problem = make_problem({.pairs = 3000, .outliers = 0.3, .noise = 0.0016},
                                      RandomStream(seed, "loose noise"));
    const auto result = register_correspondences(problem.correspondences, {.instances = 6});
    ASSERT_TRUE(result.T_target_source);
    EXPECT_TRUE(is_right(*result.T_target_source, problem.truth));
    EXPECT_EQ(result.instances.size(), 0u) << seed;
  }
}

// Seven of the ten right pairs and some wrong ones agreed on a pose 10 deg off.
TEST(LargestConsensus, APartOfTheRightPairsIsNotTheAnswer) {
  for (const std::uint64_t seed : {513, 613}) {
    const auto problem = make_problem({.outliers = 0.99, .noise = 0.001, .normal_deg = 5},
                                      RandomStream(seed, "registration_table"));
    const auto result = register_correspondences(problem.correspondences);
    ASSERT_TRUE(result.T_target_source) << seed;
    EXPECT_TRUE(is_right(*result.T_target_source, problem.truth)) << seed;
  }
}

/// Wrong pairs, each with copies a little beside it.
Correspondences jittered(int pairs, int copies, double jitter, std::uint64_t seed) {
  RandomStream random(seed, "jitter");
  const auto base = make_problem({.pairs = static_cast<std::size_t>(pairs),
                                  .outliers = 1,
                                  .noise = 0.001,
                                  .box_outliers = true},
                                 RandomStream(seed, "copied"));
  Correspondences c;
  for (int k = 0; k < copies; ++k) {
    for (int i = 0; i < pairs; ++i) {
      const auto index = static_cast<std::size_t>(i);
      c.source.push_back(base.correspondences.source[index] + jitter * random.normal3());
      c.target.push_back(base.correspondences.target[index] + jitter * random.normal3());
    }
  }
  return c;
}

// With copies taken for evidence nearly all of these have a pose.
TEST(FalseAlarms, CopiesBesideOneAnotherAreNoEvidence) {
  int poses = 0;
  for (const double jitter : {1e-9, 5e-4, 2e-3}) {
    for (const int copies : {2, 20}) {
      for (std::uint64_t seed = 0; seed < 10; ++seed) {
        poses += register_correspondences(jittered(40, copies, jitter, seed))
                     .T_target_source.has_value();
      }
    }
  }
  EXPECT_LE(poses, 3);  // 0.6 expected at the nominal rate
}

TEST(Register, MirroredPairsAreRefusedAndFlagged) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    auto problem =
        make_problem({.pairs = 300, .outliers = 0.3, .noise = 0.001}, RandomStream(seed, "mirror"));
    EXPECT_FALSE(register_correspondences(problem.correspondences).mirrored);
    for (auto& p : problem.correspondences.source) p[1] = -p[1];
    const auto result = register_correspondences(problem.correspondences);
    EXPECT_TRUE(result.mirrored) << seed;
    EXPECT_EQ(result.status, RegistrationStatus::kNoConsensus);
    EXPECT_FALSE(result.T_target_source);
  }
}

/// Of 300 pairs, some agree with one pose, others with one of the source's mirror image.
RegistrationResult with_reflection(int right, int reflected, std::uint64_t seed) {
  auto problem = make_problem({.pairs = 300, .outliers = 1, .noise = 0.001, .box_outliers = true},
                              RandomStream(seed, "reflection"));
  RandomStream random(seed, "other pose");
  const Eigen::Isometry3d other = testing::random_pose(random);
  auto& [source, target, source_normals, target_normals, weights] = problem.correspondences;
  for (int k = 0; k < right + reflected; ++k) {
    const auto i = static_cast<std::size_t>(k);
    Eigen::Vector3d p = source[i];
    if (k >= right) p.x() = -p.x();
    target[i] = (k < right ? problem.truth : other) * p + 0.001 * random.normal3();
  }
  auto result = register_correspondences(problem.correspondences);
  EXPECT_EQ(result.T_target_source && is_right(*result.T_target_source, problem.truth),
            !result.mirrored);
  return result;
}

// A few pairs more may be an accident.
TEST(Register, AReflectionMustHaveASignificantSurplus) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    EXPECT_FALSE(with_reflection(60, 66, seed).mirrored) << seed;
  }
}

// A rotation fits part of what a reflection explains: its cliques are looked at as reflections,
// too.
TEST(Register, AReflectionIsFoundBesideASmallerConsensus) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto result = with_reflection(20, 200, seed);
    EXPECT_TRUE(result.mirrored) << seed;
    EXPECT_FALSE(result.T_target_source) << seed;
    EXPECT_FALSE(with_reflection(200, 20, seed).mirrored) << seed;
  }
}

TEST(Register, OneHugeCoordinateSpoilsNothing) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    auto problem =
        make_problem({.pairs = 200, .outliers = 0.5, .noise = 0.001}, RandomStream(seed, "huge"));
    problem.correspondences.source[7][1] = 1e10;
    const auto result = register_correspondences(problem.correspondences);
    ASSERT_TRUE(result.T_target_source) << seed;
    EXPECT_TRUE(is_right(*result.T_target_source, problem.truth));
  }
}

TEST(Register, PeriodicInliersAreFound) {
  auto problem = make_problem({.pairs = 50000, .outliers = 1, .noise = 0.001, .box_outliers = true},
                              RandomStream(1, "periodic"));
  auto& c = problem.correspondences;
  RandomStream random(1, "period");
  for (std::size_t i = 7; i < c.size(); i += 20) {
    c.target[i] = problem.truth * c.source[i] + 0.001 * random.normal3();
  }
  const auto result = register_correspondences(c);
  ASSERT_TRUE(result.T_target_source);
  EXPECT_TRUE(is_right(*result.T_target_source, problem.truth));
}

TEST(Register, BestEffortGivesThreeOfSix) {
  int right = 0, refused = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto problem =
        make_problem({.pairs = 6, .outliers = 0.5, .noise = 0.0005}, RandomStream(seed, "few"));
    refused += !register_correspondences(problem.correspondences).T_target_source;
    const auto result = register_correspondences(problem.correspondences, {.best_effort = true});
    right += result.T_target_source && is_right(*result.T_target_source, problem.truth);
  }
  EXPECT_GE(right, 12);
  EXPECT_GE(refused, 10);
}

TEST(Register, StartsFromAnInitialPose) {
  const auto problem =
      make_problem({.pairs = 300, .outliers = 0.5, .noise = 0.001}, RandomStream(2, "initial"));
  Eigen::Isometry3d near = problem.truth;
  near.rotate(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()));
  const auto result = register_correspondences(problem.correspondences, {.initial = near});
  ASSERT_TRUE(result.T_target_source);
  EXPECT_LT(rotation_error_deg(*result.T_target_source, problem.truth), 0.5);
  near.translation().x() += 10;
  EXPECT_FALSE(
      register_correspondences(problem.correspondences, {.initial = near}).T_target_source);
}

TEST(Register, TurnsAboutAnAxisAlone) {
  auto problem =
      make_problem({.pairs = 200, .outliers = 0.6, .noise = 0.002}, RandomStream(3, "yaw"));
  RandomStream random(3, "yaw noise");
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 2).normalized();
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  truth.rotate(Eigen::AngleAxisd(2, axis));
  auto& c = problem.correspondences;
  for (std::size_t i = 0; i < c.size(); ++i) {
    if (problem.inlier[i]) c.target[i] = truth * c.source[i] + 0.001 * random.normal3();
  }
  const auto result = register_correspondences(c, {.rotation_axis = axis});
  ASSERT_TRUE(result.T_target_source);
  EXPECT_LT(rotation_error_deg(*result.T_target_source, truth), 0.5);
  EXPECT_NEAR((result.T_target_source->linear() * axis - axis).norm(), 0, 1e-12);
  // Turns about other axes are no part of the answer, nor of its covariance.
  Vector6d across = Vector6d::Zero();
  across.head<3>() = axis.cross(Eigen::Vector3d::UnitX());
  EXPECT_NEAR((result.covariance * across).norm(), 0, 1e-12);
  EXPECT_GT(result.covariance.trace(), 0);
}

TEST(Register, ShiftsAlone) {
  auto problem =
      make_problem({.pairs = 200, .outliers = 0.6, .noise = 0.002}, RandomStream(6, "shift"));
  RandomStream random(6, "shift noise");
  const Eigen::Vector3d shift(0.3, -0.2, 0.1);
  auto& c = problem.correspondences;
  for (std::size_t i = 0; i < c.size(); ++i) {
    if (problem.inlier[i]) c.target[i] = c.source[i] + shift + 0.001 * random.normal3();
  }
  const auto result = register_correspondences(c, {.translation_only = true});
  ASSERT_TRUE(result.T_target_source);
  EXPECT_EQ(result.T_target_source->linear(), Eigen::Matrix3d::Identity());
  EXPECT_LT((result.T_target_source->translation() - shift).norm(), 5e-4);
  Correspondences exact;
  exact.source = exact.target = c.source;
  for (auto& p : exact.target) p += shift;
  EXPECT_FALSE(register_correspondences(exact, {.translation_only = true}).runner_up);
  EXPECT_THROW(register_correspondences(
                   c, {.rotation_axis = Eigen::Vector3d::UnitZ(), .translation_only = true}),
               BadInput);
  for (const double length : {0.0, 1e-320, 1e200, HUGE_VAL}) {
    EXPECT_THROW(register_correspondences(c, {.rotation_axis = Eigen::Vector3d(0, length, 0)}),
                 BadInput)
        << length;
  }
}

TEST(Register, RefusesPointsTooFarAwayToSquare) {
  auto c = make_problem({.pairs = 30}, RandomStream(5, "far")).correspondences;
  c.target[3].y() = -1e300;
  EXPECT_THROW(register_correspondences(c, {}), BadInput);
  EXPECT_THROW(certify(Eigen::Isometry3d::Identity(), c, {}, Primitive::kPoint), BadInput);
}

TEST(Register, EstimatesTheScale) {
  for (const double scale : {0.3, 1.0, 7.0}) {
    auto problem =
        make_problem({.pairs = 300, .outliers = 0.6, .noise = 0.001}, RandomStream(4, "scale"));
    for (auto& p : problem.correspondences.source) p /= scale;
    const auto result = register_correspondences(problem.correspondences, {.estimate_scale = true});
    ASSERT_TRUE(result.T_target_source) << scale;
    EXPECT_NEAR(result.scale / scale, 1, 0.01);
    EXPECT_TRUE(is_right(*result.T_target_source, problem.truth));
  }
}

TEST(Register, WeightsGuideAndExclude) {
  auto problem =
      make_problem({.pairs = 200, .outliers = 0.5, .noise = 0.001}, RandomStream(5, "weights"));
  auto& c = problem.correspondences;
  for (const bool right : problem.inlier) c.weights.push_back(right ? 2 : 1);
  const auto all = register_correspondences(c);
  ASSERT_TRUE(all.T_target_source);
  EXPECT_TRUE(is_right(*all.T_target_source, problem.truth));
  for (std::size_t i = 0; i < c.size(); i += 2) c.weights[i] = 0;
  const auto half = register_correspondences(c);
  ASSERT_TRUE(half.T_target_source);
  for (const int i : half.inliers) EXPECT_EQ(i % 2, 1);
  c.weights[3] = -1;
  EXPECT_THROW(register_correspondences(c), std::exception);
}

TEST(Register, CovarianceMatchesTheError) {
  for (const double outliers : {0.5, 0.95}) {
    double sum = 0;
    constexpr int kRuns = 40;
    for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
      const auto problem =
          make_problem({.outliers = outliers, .noise = 0.001}, RandomStream(seed, "nees"));
      const auto result = register_correspondences(problem.correspondences);
      ASSERT_TRUE(result.T_target_source);
      const Vector6d error = log_se3(problem.truth * result.T_target_source->inverse());
      sum += error.dot(result.covariance.inverse() * error);
    }
    EXPECT_GT(sum / kRuns, 4.5) << outliers;
    EXPECT_LT(sum / kRuns, 8) << outliers;
  }
}

TEST(Register, CovarianceMatchesTheErrorOfUnequalWeights) {
  double steep = 0, mixed = 0;
  constexpr int kRuns = 60;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    RandomStream random(seed, "weights");
    for (double* sum : {&steep, &mixed}) {
      auto problem = make_problem({.pairs = 300, .noise = 0.001}, random.fork("problem"));
      for (int i = 0; i < 300; ++i) {
        const double w = sum == &steep ? std::pow(random.uniform(), 4) : i < 20 ? 1 : 1e-3;
        problem.correspondences.weights.push_back(w);
      }
      const auto result = register_correspondences(problem.correspondences);
      ASSERT_TRUE(result.T_target_source);
      const Vector6d error = log_se3(problem.truth * result.T_target_source->inverse());
      *sum += error.dot(result.covariance.inverse() * error) / kRuns;
    }
  }
  for (const double nees : {steep, mixed}) {
    EXPECT_GT(nees, 4.5);
    EXPECT_LT(nees, 8);
  }
}

TEST(Register, CovarianceDoesNotDependOnTheUnitOfEqualWeights) {
  auto problem = make_problem({.pairs = 100, .noise = 0.001}, RandomStream(3, "equal weights"));
  const auto plain = register_correspondences(problem.correspondences);
  problem.correspondences.weights.assign(100, 4);
  const auto scaled = register_correspondences(problem.correspondences);
  EXPECT_LT((scaled.covariance - plain.covariance).norm(), 1e-9 * plain.covariance.norm());
}

}  // namespace
}  // namespace palpate::registration
