// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/registration/cloud_registration.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

geometry::PointCloud scan_of(const geometry::TriangleMesh& mesh, double noise,
                             const RandomStream& random) {
  geometry::PointCloud cloud;
  RandomStream off = random.fork("noise");
  for (const auto& s : geometry::sample_surface(mesh, 5000, random.fork("points"))) {
    cloud.points.push_back(s.point + noise * off.normal3());
  }
  return cloud;
}

/// Mean normalised squared error of the refinement, the pose given: 6 where the covariance is
/// right, less where it is too large.
double mean_nees(const geometry::TriangleMesh& mesh, double noise) {
  constexpr int kRuns = 6;
  double sum = 0;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    RandomStream random(seed, "cloud covariance");
    const Eigen::Isometry3d truth = testing::random_pose(random);
    const auto source = scan_of(mesh, noise, random.fork("source")),
               target = geometry::transformed(truth, scan_of(mesh, noise, random.fork("target")));
    CloudOptions options;
    options.registration.initial = truth;
    const auto result = register_clouds(source, target, options).result;
    EXPECT_TRUE(result.T_target_source);
    if (!result.T_target_source) return 0;
    const Vector6d error = log_se3(truth * result.T_target_source->inverse());
    sum += error.dot(result.covariance.inverse() * error) / kRuns;
  }
  return sum;
}

TEST(RegisterClouds, CovarianceIsNotTooSmall) {
  const geometry::TriangleMesh bracket = geometry::load_known_object("bracket").mesh,
                               duck = geometry::load_known_object("duck").mesh;
  for (const geometry::TriangleMesh* mesh : {&bracket, &duck}) {
    for (const double noise : {0.0003, 0.001}) {
      const double nees = mean_nees(*mesh, noise);
      EXPECT_GT(nees, 0.2) << noise;
      EXPECT_LT(nees, 9) << noise;
    }
  }
}

}  // namespace
}  // namespace palpate::registration
