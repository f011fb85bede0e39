// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/registration.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using testing::make_problem;
using testing::rotation_error_deg;
using testing::translation_error_mm;

const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInf = std::numeric_limits<double>::infinity();

bool succeeded(const RegistrationResult& result, const Eigen::Isometry3d& truth) {
  return result.T_target_source && rotation_error_deg(*result.T_target_source, truth) < 5 &&
         translation_error_mm(*result.T_target_source, truth) < 10;
}

int successes(const testing::ProblemOptions& problem_options, const RegistrationOptions& options,
              std::uint64_t runs) {
  int count = 0;
  for (std::uint64_t seed = 0; seed < runs; ++seed) {
    const auto problem = make_problem(problem_options, RandomStream(seed, "register"));
    count += succeeded(register_correspondences(problem.correspondences, options), problem.truth);
  }
  return count;
}

TEST(Register, SucceedsThroughNinetyFivePercentOutliers) {
  for (const bool box : {false, true}) {
    for (const double outliers : {0.0, 0.1, 0.5, 0.9, 0.95}) {
      EXPECT_EQ(successes({.outliers = outliers, .noise = 0.001, .box_outliers = box}, {}, 20), 20)
          << outliers;
    }
  }
  EXPECT_EQ(successes({.outliers = 0.98, .noise = 0.001}, {}, 20), 20);
  EXPECT_GE(successes({.outliers = 0.99, .noise = 0.001}, {}, 20), 19);
}

TEST(Register, NormalsHelp) {
  EXPECT_EQ(successes({.outliers = 0.99, .noise = 0.001, .normal_deg = 5, .normals = true},
                      {.normal_noise_deg = 5}, 20),
            20);
  // Five inliers; 0.95 is aimed at: of 20 runs, fewer than 15 succeed once in 3000 times.
  EXPECT_GE(successes({.outliers = 0.995, .noise = 0.001, .normal_deg = 5, .normals = true},
                      {.normal_noise_deg = 5}, 20),
            15);
}

TEST(Register, IsAccurateAndExplainsItself) {
  const auto problem = make_problem({.outliers = 0.5, .noise = 0.001}, RandomStream(1, "register"));
  const auto result = register_correspondences(problem.correspondences);
  ASSERT_EQ(result.status, RegistrationStatus::kFound);
  EXPECT_LT(rotation_error_deg(*result.T_target_source, problem.truth), 0.4);
  EXPECT_LT(translation_error_mm(*result.T_target_source, problem.truth), 0.3);
  EXPECT_LT(result.false_alarms, 1e-30);
  EXPECT_EQ(result.rank, 6);
  EXPECT_GT(result.information.diagonal().minCoeff(), 0);
  ASSERT_EQ(result.residuals.size(), 1000u);
  double sum = 0;
  for (const int i : result.inliers) {
    const auto index = static_cast<std::size_t>(i);
    EXPECT_EQ(result.weights[index], 1);
    EXPECT_LT(result.residuals[index], 1.05 * 0.004);
    sum += result.residuals[index] * result.residuals[index];
  }
  EXPECT_NEAR(result.cost, sum, 1e-9);
  EXPECT_NEAR(static_cast<double>(result.inliers.size()), 500, 10);
  EXPECT_LE(result.bound, 1e-6 * result.cost);
  EXPECT_GE(result.seconds, result.search_seconds);
}

TEST(Register, PlanesRefineToo) {
  const auto problem =
      make_problem({.pairs = 400, .outliers = 0.5, .noise = 0.001, .normals = true},
                   RandomStream(2, "register"));
  const auto result =
      register_correspondences(problem.correspondences, {.primitive = Primitive::kPlane});
  ASSERT_EQ(result.status, RegistrationStatus::kFound);
  EXPECT_TRUE(succeeded(result, problem.truth));
}

TEST(Register, GncAloneToHalfOutliers) {
  for (const RobustCost cost : {RobustCost::kTruncatedLeastSquares, RobustCost::kGemanMcClure}) {
    EXPECT_EQ(successes({.pairs = 300, .outliers = 0.5, .noise = 0.001},
                        {.method = Method::kGnc, .cost = cost}, 10),
              10);
  }
}

TEST(Register, IsTheSameEachTime) {
  const auto problem =
      make_problem({.outliers = 0.97, .noise = 0.001}, RandomStream(3, "register"));
  const auto first = register_correspondences(problem.correspondences, {.seed = 5});
  const auto again = register_correspondences(problem.correspondences, {.seed = 5});
  EXPECT_EQ(first.inliers, again.inliers);
  EXPECT_EQ(first.T_target_source->matrix(), again.T_target_source->matrix());
}

/// Problems of 20, 100 and 1000 wrong pairs for which a pose is given.
struct Accidents {
  int wrong = 0, right = 0;
};

Accidents accidents(testing::ProblemOptions problem_options, const RegistrationOptions& options,
                    std::uint64_t runs) {
  Accidents count;
  for (std::uint64_t seed = 0; seed < runs; ++seed) {
    problem_options.pairs = seed % 3 == 0 ? 1000 : seed % 3 == 1 ? 100 : 20;
    problem_options.outliers = 1;
    problem_options.noise = 0.001;
    problem_options.normal_deg = 5;
    const auto problem = make_problem(problem_options, RandomStream(seed, "outliers"));
    const auto result = register_correspondences(problem.correspondences, options);
    const bool right = succeeded(result, problem.truth);
    count.right += right;
    count.wrong += result.T_target_source && !right;
    if (result.status != RegistrationStatus::kNoConsensus) continue;
    EXPECT_FALSE(result.T_target_source);
    EXPECT_TRUE(result.inliers.empty());
    EXPECT_GE(result.false_alarms, options.max_false_alarms);
  }
  return count;
}

// At the nominal rate of .01 more than 6 of 300 come up once in 30 times.
TEST(Register, OutliersAloneAreNoConsensus) {
  EXPECT_LE(accidents({.box_outliers = true}, {}, 300).wrong, 6);
  EXPECT_EQ(accidents({.box_outliers = true, .normals = true}, {.normal_noise_deg = 5}, 60).wrong,
            0);
  const auto problem = make_problem({.pairs = 200, .outliers = 1}, RandomStream(1, "outliers"));
  EXPECT_EQ(register_correspondences(problem.correspondences, {.method = Method::kGnc}).status,
            RegistrationStatus::kNoConsensus);
}

// Some of the pairs of a shuffled surface are right to within the bound, as neighbours get each
// other's targets, so that a few poses are right; the other poses are accidents. On a mug walls
// agree with walls at many poses.
TEST(Register, ShuffledSurfacesAreNoConsensus) {
  const auto mug = geometry::load_known_object("mug");
  for (const auto* mesh : {&testing::bunny(), &mug.mesh}) {
    const auto points = accidents({.mesh = mesh}, {}, 300);
    const auto normals = accidents({.normals = true, .mesh = mesh}, {.normal_noise_deg = 5}, 300);
    EXPECT_LE(points.wrong, 6);
    EXPECT_LE(normals.wrong, 6);
    EXPECT_LE(points.right + normals.right, 30);
  }
}

// A mug turned about its axis or upside down lies on itself, which few random poses show: these
// five had 1e-10 to 5e-9 false alarms by 64 poses, and have 1e-5 to 0.04 by 8192.
TEST(Register, ManyPosesTellWhatAMugGathersByChance) {
  const auto mug = geometry::load_known_object("mug");
  for (const std::uint64_t seed : {34, 42, 89, 336, 464}) {
    const auto problem = make_problem(
        {.outliers = 1, .noise = 0.001, .normal_deg = 5, .normals = true, .mesh = &mug.mesh},
        RandomStream(seed, "registration_table"));
    const auto result = register_correspondences(problem.correspondences, {.normal_noise_deg = 5});
    EXPECT_GT(result.false_alarms, 1e-7) << seed;
  }
}

// With a bound of a third of the object's size nearly all poses are the same to within three
// bounds, and what agrees at them by chance counts nevertheless: 1e-58 false alarms were stated.
TEST(Register, OutliersWithinAWideBoundAreNoConsensus) {
  int poses = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const auto problem = make_problem({.pairs = 200, .outliers = 1}, RandomStream(seed, "wide"));
    poses += register_correspondences(problem.correspondences, {.noise_bound = 0.04})
                 .T_target_source.has_value();
  }
  EXPECT_LE(poses, 2);
}

TEST(Register, CopiedOutliersAreNoConsensus) {
  int poses = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    auto problem = make_problem({.pairs = 100, .outliers = 1, .box_outliers = true},
                                RandomStream(seed, "copies"));
    auto& c = problem.correspondences;
    c.target_normals.clear();
    for (std::size_t i = 0; i < 200; ++i) {
      c.source.push_back(c.source[i]);
      c.target.push_back(c.target[i]);
    }
    poses += register_correspondences(c).T_target_source.has_value();
  }
  EXPECT_LE(poses, 2);  // 0.6 expected; more than 2 once in 40 times
}

TEST(Register, FewCorrespondences) {
  for (std::size_t pairs = 0; pairs < 8; ++pairs) {
    Correspondences few;
    if (pairs > 0) {
      few = make_problem({.pairs = pairs}, RandomStream(4, "register")).correspondences;
    }
    const auto result = register_correspondences(few);
    EXPECT_EQ(result.weights.size(), pairs);
    if (pairs < 3) {
      EXPECT_EQ(result.status, RegistrationStatus::kDegenerate);
      EXPECT_FALSE(result.T_target_source);
    }
    if (pairs == 3) {
      EXPECT_EQ(result.status, RegistrationStatus::kNoConsensus);
      EXPECT_FALSE(result.T_target_source);
    }
    // Three lengths that agree may be chance; from five pairs on they cannot be.
    EXPECT_TRUE(pairs < 5 || result.status == RegistrationStatus::kFound) << pairs;
  }
}

TEST(Register, IdenticalAndCollinearPointsAreDegenerate) {
  Correspondences same;
  same.source.assign(20, Eigen::Vector3d(0.1, 0, 0));
  same.target.assign(20, Eigen::Vector3d(0, 0.2, 0));
  EXPECT_EQ(register_correspondences(same).status, RegistrationStatus::kDegenerate);

  RandomStream random(5, "register");
  auto problem = make_problem({.pairs = 200}, RandomStream(5, "register"));
  for (const double noise : {0.0, 0.001}) {
    for (std::size_t i = 0; i < 200; ++i) {
      problem.correspondences.source[i] = random.uniform(-0.1, 0.1) * Eigen::Vector3d::UnitX();
      problem.correspondences.target[i] =
          problem.truth * problem.correspondences.source[i] + noise * random.normal3();
    }
    EXPECT_EQ(register_correspondences(problem.correspondences).status,
              RegistrationStatus::kDegenerate);
  }
}

TEST(Register, NothingLeftIsNoEvidence) {
  auto problem = make_problem({.pairs = 40}, RandomStream(4, "register"));
  for (auto* list : {&problem.correspondences.source, &problem.correspondences.target}) {
    for (auto& p : *list) p *= 1e9;
  }
  const auto result = register_correspondences(problem.correspondences);
  EXPECT_EQ(result.status, RegistrationStatus::kNoConsensus);
  EXPECT_GT(result.false_alarms, 0.01);
}

TEST(Register, DuplicatedPointsChangeNothing) {
  auto problem = make_problem({.pairs = 100, .noise = 0.001}, RandomStream(6, "register"));
  auto& c = problem.correspondences;
  for (std::size_t i = 0; i < 100; ++i) {
    c.source.push_back(c.source[i]);
    c.target.push_back(c.target[i]);
  }
  c.target_normals.clear();
  const auto result = register_correspondences(c);
  EXPECT_EQ(result.status, RegistrationStatus::kFound);
  EXPECT_TRUE(succeeded(result, problem.truth));
}

TEST(Register, HugeAndTinyCoordinates) {
  for (const double scale : {1e-6, 1e6}) {
    auto problem =
        make_problem({.pairs = 300, .outliers = 0.5, .noise = 0.001}, RandomStream(7, "register"));
    for (auto& p : problem.correspondences.source) p *= scale;
    for (auto& p : problem.correspondences.target) p *= scale;
    const auto result =
        register_correspondences(problem.correspondences, {.noise_bound = 0.004 * scale});
    ASSERT_EQ(result.status, RegistrationStatus::kFound);
    EXPECT_LT(rotation_error_deg(*result.T_target_source, problem.truth), 1);
  }
  auto far = make_problem({.pairs = 300, .outliers = 0.5, .noise = 0.001}, RandomStream(7, "far"));
  for (auto& p : far.correspondences.source) p += Eigen::Vector3d(1e6, 1e6, 1e6);
  const auto result = register_correspondences(far.correspondences);
  ASSERT_EQ(result.status, RegistrationStatus::kFound);
  EXPECT_LT(rotation_error_deg(*result.T_target_source, far.truth), 1);
}

TEST(Register, FarOutliersWithATightBound) {
  for (const bool normals : {false, true}) {
    for (const double bound : {1e-9, 1e-6, 0.004}) {
      auto problem = make_problem({.pairs = 100, .outliers = 1, .normals = normals},
                                  RandomStream(12, "register"));
      auto& c = problem.correspondences;
      for (std::size_t i = 0; i < 100; i += 10) c.source[i] += Eigen::Vector3d(1e6, 1e6, 1e6);
      for (auto& p : c.target) p *= 1e-5;
      const auto result = register_correspondences(
          c, {.noise_bound = bound, .normal_noise_deg = normals ? 5.0 : 0.0});
      EXPECT_EQ(result.status, RegistrationStatus::kNoConsensus) << normals << " " << bound;
      EXPECT_GE(result.false_alarms, 0.01) << normals << " " << bound;  // not nan
    }
  }
}

TEST(Register, MirroredCloudGivesNoReflection) {
  auto problem = make_problem({.pairs = 500}, RandomStream(8, "register"));
  for (auto& p : problem.correspondences.source) p[1] = -p[1];
  const auto result = register_correspondences(problem.correspondences);
  if (result.T_target_source) {
    EXPECT_NEAR(result.T_target_source->linear().determinant(), 1, 1e-9);
    EXPECT_LT(result.inliers.size(), 250u);
  }
}

TEST(Register, NoiseBoundOffByTwoCostsLittle) {
  for (const double outliers : {0.5, 0.9, 0.95}) {
    for (const double factor : {0.5, 2.0}) {
      EXPECT_GE(successes({.outliers = outliers, .noise = 0.001, .normal_deg = 5, .normals = true},
                          {.noise_bound = 0.004 * factor, .normal_noise_deg = 5}, 20),
                19)
          << outliers << " " << factor;
    }
  }
}

TEST(Register, KeepsTheWeightsOfGncIfAsked) {
  const auto problem =
      make_problem({.pairs = 200, .outliers = 0.3, .noise = 0.001}, RandomStream(11, "register"));
  const auto result = register_correspondences(problem.correspondences,
                                               {.method = Method::kGnc, .keep_history = true});
  ASSERT_EQ(result.history.size(), static_cast<std::size_t>(result.iterations));
  EXPECT_EQ(result.history.back().weights, result.weights);
}

TEST(Register, BadInput) {
  const auto good = make_problem({.pairs = 10}, RandomStream(9, "register")).correspondences;
  for (const double bound : {0.0, -0.004, kNan, kInf}) {
    EXPECT_THROW(register_correspondences(good, {.noise_bound = bound}), BadInput);
  }
  EXPECT_THROW(register_correspondences(good, {.normal_noise_deg = -1}), BadInput);
  EXPECT_THROW(register_correspondences(good, {.max_false_alarms = 0}), BadInput);
  for (const double value : {kNan, kInf, -kInf}) {
    auto bad = good;
    bad.source[3][0] = value;
    EXPECT_THROW(register_correspondences(bad), BadInput);
    bad = good;
    bad.target[3][2] = value;
    EXPECT_THROW(register_correspondences(bad), BadInput);
  }
}

TEST(Register, ManyCorrespondences) {
  const auto problem =
      make_problem({.pairs = 50000, .outliers = 0.9, .noise = 0.001}, RandomStream(10, "register"));
  const auto result = register_correspondences(problem.correspondences);
  EXPECT_EQ(result.status, RegistrationStatus::kFound);
  EXPECT_LT(rotation_error_deg(*result.T_target_source, problem.truth), 0.2);
  EXPECT_NEAR(static_cast<double>(result.inliers.size()), 5000, 150);
}

// Far from the origin, as in maps, the information about it drowns all but the arms to it.
TEST(RegisterCorrespondences, CovarianceFarFromTheOrigin) {
  auto problem = make_problem({.pairs = 100, .noise = 0.001}, RandomStream(5, "far"));
  const auto near = register_correspondences(problem.correspondences);
  const Eigen::Vector3d shift(1e7, -2e7, 3e6);
  for (auto& p : problem.correspondences.target) p += shift;
  const auto far = register_correspondences(problem.correspondences);
  ASSERT_TRUE(near.T_target_source && far.T_target_source);
  const Eigen::Matrix3d turn = near.covariance.topLeftCorner<3, 3>();
  EXPECT_LT((far.covariance.topLeftCorner<3, 3>() - turn).norm(), 1e-3 * turn.norm());
  const Eigen::Matrix3d moved = skew(shift) * turn * skew(shift).transpose();
  EXPECT_LT((far.covariance.bottomRightCorner<3, 3>() - moved).norm(), 1e-3 * moved.norm());
}

}  // namespace
}  // namespace palpate::registration
