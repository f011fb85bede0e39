// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/pose.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <numeric>

#include "palpate/core/error.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using testing::make_problem;
using testing::rotation_error_deg;
using testing::translation_error_mm;

constexpr Primitive kBoth[] = {Primitive::kPoint, Primitive::kPlane};

double sum_of(const std::vector<double>& squares) {
  return std::accumulate(squares.begin(), squares.end(), 0.0);
}

TEST(Pose, RecoversTheExactPose) {
  for (const Primitive primitive : kBoth) {
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
      const auto problem = make_problem({.pairs = 20}, RandomStream(seed, "pose"));
      const PoseEstimate estimate = solve_pose(problem.correspondences, {}, primitive);
      EXPECT_EQ(estimate.status, Status::kCertified);
      EXPECT_EQ(estimate.rank, 6);
      EXPECT_LT(rotation_error_deg(estimate.T_target_source, problem.truth), 1e-4);
      EXPECT_LT(translation_error_mm(estimate.T_target_source, problem.truth), 1e-4);
    }
  }
}

TEST(Pose, WeightsOfZeroRemovePairs) {
  auto problem = make_problem({.pairs = 60, .outliers = 0.5}, RandomStream(1, "pose"));
  std::vector<double> weights;
  for (const bool inlier : problem.inlier) weights.push_back(inlier ? 1 : 0);
  for (const Primitive primitive : kBoth) {
    const auto with = solve_pose(problem.correspondences, weights, primitive);
    const auto without = solve_pose(problem.correspondences, {}, primitive);
    EXPECT_LT(rotation_error_deg(with.T_target_source, problem.truth), 1e-4);
    EXPECT_GT(rotation_error_deg(without.T_target_source, problem.truth), 1);
  }
}

TEST(Pose, ScalesAndOffsetsOfAMillion) {
  for (const Primitive primitive : kBoth) {
    for (const double scale : {1e-6, 1e6}) {
      auto problem = make_problem({.pairs = 50, .noise = 0.001}, RandomStream(2, "pose"));
      const auto plain = solve_pose(problem.correspondences, {}, primitive);
      for (auto& p : problem.correspondences.source) p *= scale;
      for (auto& p : problem.correspondences.target) p *= scale;
      const auto scaled = solve_pose(problem.correspondences, {}, primitive);
      EXPECT_EQ(scaled.status, Status::kCertified);
      EXPECT_LT(rotation_error_deg(scaled.T_target_source, plain.T_target_source), 1e-4);
      EXPECT_NEAR(scaled.cost / (scale * scale * plain.cost), 1, 1e-6);
    }
    auto far = make_problem({.pairs = 50}, RandomStream(2, "pose"));
    for (auto& p : far.correspondences.source) p += Eigen::Vector3d(1e6, 1e6, -1e6);
    const auto moved = solve_pose(far.correspondences, {}, primitive);
    EXPECT_EQ(moved.status, Status::kCertified);
    EXPECT_LT(rotation_error_deg(moved.T_target_source, far.truth), 1e-4);
  }
}

TEST(Pose, RecognisesDegenerateProblems) {
  const auto full = make_problem({.pairs = 40, .normals = true}, RandomStream(3, "pose"));
  const auto few = [&](int count) {
    std::vector<int> indices;
    for (int i = 0; i < count; ++i) indices.push_back(i * 13 % 40);
    return subset(full.correspondences, indices);
  };
  for (int count = 0; count < 3; ++count) {
    EXPECT_EQ(solve_pose(few(count), {}, Primitive::kPoint).status, Status::kDegenerate) << count;
  }
  EXPECT_EQ(solve_pose(few(3), {}, Primitive::kPoint).status, Status::kCertified);
  EXPECT_EQ(solve_pose(few(4), {}, Primitive::kPoint).status, Status::kCertified);
  for (int count = 0; count < 6; ++count) {
    EXPECT_EQ(solve_pose(few(count), {}, Primitive::kPlane).status, Status::kDegenerate) << count;
  }
  auto plane = full.correspondences;
  for (auto& n : plane.target_normals) n = Eigen::Vector3d::UnitX();
  EXPECT_EQ(solve_pose(plane, {}, Primitive::kPlane).rank, 3);

  auto same = full.correspondences;
  for (auto& p : same.source) p = Eigen::Vector3d(0.1, 0.2, 0.3);
  EXPECT_EQ(solve_pose(same, {}, Primitive::kPoint).status, Status::kDegenerate);

  auto line = full.correspondences;
  for (std::size_t i = 0; i < line.size(); ++i) {
    line.source[i] = 0.01 * static_cast<double>(i) * Eigen::Vector3d(1, 2, 3);
    line.target[i] = full.truth * line.source[i];
  }
  EXPECT_EQ(solve_pose(line, {}, Primitive::kPoint).rank, 5);
}

TEST(Pose, FreeDirectionsOfCylinderSphereAndCorner) {
  RandomStream random(4, "pose");
  Correspondences cylinder, sphere;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d n = random.unit_vector(),
                          flat = Eigen::Vector3d(n[0], n[1], 0).normalized();
    sphere.target.push_back(0.05 * n);
    sphere.target_normals.push_back(n);
    cylinder.target.push_back(0.05 * flat + Eigen::Vector3d(0, 0, random.uniform(-0.1, 0.1)));
    cylinder.target_normals.push_back(flat);
  }
  sphere.source = sphere.target;
  cylinder.source = cylinder.target;
  EXPECT_EQ(solve_pose(sphere, {}, Primitive::kPlane).rank, 3);
  EXPECT_EQ(solve_pose(cylinder, {}, Primitive::kPlane).rank, 4);
  EXPECT_EQ(solve_pose(cylinder, {}, Primitive::kPlane).status, Status::kDegenerate);
}

// Against every angle about the axis, each with the shift that is best for it.
TEST(Pose, NoTurnAboutTheAxisIsBetter) {
  const Eigen::Vector3d axis(1, -2, 0.5);
  for (const Primitive primitive : kBoth) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const auto problem =
          make_problem({.pairs = 30, .outliers = 0.5, .noise = 0.005}, RandomStream(seed, "axis"));
      const Correspondences& c = problem.correspondences;
      const auto best = solve_pose(c, {}, primitive, AllowedTurns{.axis = axis});
      EXPECT_NEAR(best.cost, sum_of(squared_residuals(c, best.T_target_source, primitive)), 1e-12);
      for (int k = 0; k < 720; ++k) {
        Correspondences turned = c;
        const Eigen::AngleAxisd turn(k * std::numbers::pi / 360, axis.normalized());
        for (auto& p : turned.source) p = turn * p;
        const auto shifted = solve_pose(turned, {}, primitive, AllowedTurns{.none = true});
        EXPECT_GE(shifted.cost, best.cost * (1 - 1e-9));
      }
    }
  }
}

TEST(Pose, MirroredPointsGiveARotation) {
  auto problem = make_problem({.pairs = 100}, RandomStream(5, "pose"));
  for (auto& p : problem.correspondences.source) p[0] = -p[0];
  const auto estimate = solve_pose(problem.correspondences, {}, Primitive::kPoint);
  EXPECT_NEAR(estimate.T_target_source.linear().determinant(), 1, 1e-9);
  EXPECT_NEAR(align_points(problem.correspondences, {}).linear().determinant(), 1, 1e-9);
  EXPECT_GT(std::sqrt(estimate.cost / 100), 0.01);
}

TEST(Certify, AcceptsTheBestPoseAndBoundsOthers) {
  RandomStream random(6, "certify");
  for (const Primitive primitive : kBoth) {
    const auto problem = make_problem({.pairs = 30, .noise = 0.001}, RandomStream(6, "pose"));
    const auto best = solve_pose(problem.correspondences, {}, primitive);
    const auto again = certify(best.T_target_source, problem.correspondences, {}, primitive);
    EXPECT_EQ(again.status, Status::kCertified);
    for (int k = 0; k < 50; ++k) {
      Eigen::Isometry3d T = best.T_target_source;
      if (k % 2 == 0) T.linear() = T.linear() * exp_so3(0.02 * random.unit_vector());
      T.translation() += 0.001 * random.unit_vector();
      const auto other = certify(T, problem.correspondences, {}, primitive);
      EXPECT_EQ(other.status, Status::kUncertified);
      EXPECT_GE(other.bound, other.cost - best.cost);
      EXPECT_LE(other.bound, other.cost - best.cost + 2e-6 * other.reference);
    }
  }
}

TEST(Pose, BadWeightsAndPoses) {
  const auto problem = make_problem({.pairs = 5}, RandomStream(7, "pose"));
  EXPECT_THROW(solve_pose(problem.correspondences, {1, 1}, Primitive::kPoint), BadInput);
  EXPECT_THROW(solve_pose(problem.correspondences, {1, 1, -1, 1, 1}, Primitive::kPoint), BadInput);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(solve_pose(problem.correspondences, {1, 1, nan, 1, 1}, Primitive::kPoint), BadInput);
  Eigen::Isometry3d T = problem.truth;
  T.translation()[0] = nan;
  EXPECT_THROW(certify(T, problem.correspondences, {}, Primitive::kPoint), BadInput);
}

// The reflection that mirrors points costs less than every rotation, and must not be proven.
TEST(Certify, NoPoseWhoseCostOverflowsIsCertified) {
  const auto problem = make_problem({.pairs = 20}, RandomStream(4, "far"));
  for (const Primitive primitive : kBoth) {
    for (const double shift : {1e150, 1e200, 1e300}) {
      Eigen::Isometry3d T = problem.truth;
      T.translation().x() = shift;
      EXPECT_EQ(certify(T, problem.correspondences, {}, primitive).status, Status::kUncertified);
    }
  }
}

TEST(Certify, RefusesReflectionsAndStretchedRotations) {
  auto problem = make_problem({.pairs = 30}, RandomStream(8, "pose"));
  const Eigen::Vector3d mirror(1, -1, 1);
  for (auto& p : problem.correspondences.source) p = mirror.asDiagonal() * p;
  Eigen::Isometry3d reflection = problem.truth;
  reflection.linear() = problem.truth.linear() * mirror.asDiagonal();
  EXPECT_THROW(certify(reflection, problem.correspondences, {}, Primitive::kPoint), BadInput);
  Eigen::Isometry3d stretched = problem.truth;
  stretched.linear() *= 1.001;
  EXPECT_THROW(certify(stretched, problem.correspondences, {}, Primitive::kPoint), BadInput);
}

}  // namespace
}  // namespace palpate::registration
