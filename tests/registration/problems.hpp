// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>
#include <string>

#include "palpate/core/assets.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "palpate/geometry/mesh/sampling.hpp"
#include "palpate/registration/correspondences.hpp"

namespace palpate::registration::testing {

/// The bunny, 0.11 m across its longest side, centred.
inline const geometry::TriangleMesh& bunny() {
  static const geometry::TriangleMesh mesh = [] {
    auto loaded = geometry::load_mesh(asset("bunny.ply"));
    const auto box = geometry::bounds(loaded);
    const double scale = 0.11 / box.sizes().maxCoeff();
    for (auto& vertex : loaded.vertices) vertex = scale * (vertex - box.center());
    return loaded;
  }();
  return mesh;
}

struct ProblemOptions {
  std::size_t pairs = 1000;
  double outliers = 0;        ///< share of the pairs
  double noise = 0;           ///< m an axis, on target points
  double normal_deg = 0;      ///< per tangent axis, on target normals
  bool box_outliers = false;  ///< uniform in the target's box; else other points of the surface
  bool normals = false;       ///< keep them
  const geometry::TriangleMesh* mesh = nullptr;  ///< the bunny if none
};

struct Problem {
  Correspondences correspondences;
  Eigen::Isometry3d truth;  ///< T_target_source
  std::vector<bool> inlier;
};

inline Eigen::Isometry3d random_pose(RandomStream& random, double shift = 0.1) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = random.rotation();
  T.translation() = shift * random.normal3();
  return T;
}

inline Eigen::Vector3d tilted(const Eigen::Vector3d& n, double degrees, RandomStream& random) {
  const Eigen::Matrix3d frame = frame_with_z(n);
  const double s = degrees * std::numbers::pi / 180;
  const double x = random.normal(), y = random.normal();
  return (n + s * (x * frame.col(0) + y * frame.col(1))).normalized();
}

/// Moved and noisy samples of a surface; outliers are pairs with another sample's target.
inline Problem make_problem(const ProblemOptions& options, RandomStream random) {
  const auto& mesh = options.mesh ? *options.mesh : bunny();
  const auto samples = geometry::sample_surface(mesh, options.pairs, random.fork("surface"));
  Problem problem;
  problem.truth = random_pose(random);
  const Eigen::Matrix3d R = problem.truth.linear();
  auto& [source, target, source_normals, target_normals, weights] = problem.correspondences;
  for (const auto& sample : samples) {
    source.push_back(sample.point);
    target.push_back(problem.truth * sample.point + options.noise * random.normal3());
    source_normals.push_back(sample.normal);
    target_normals.push_back(tilted(R * sample.normal, options.normal_deg, random));
  }
  const auto clean = target;
  const auto clean_normals = target_normals;
  Eigen::AlignedBox3d box;
  for (const auto& p : clean) box.extend(p);
  std::vector<std::size_t> order(options.pairs);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  problem.inlier.assign(options.pairs, true);
  const auto outliers =
      static_cast<std::size_t>(std::lround(options.outliers * static_cast<double>(options.pairs)));
  for (std::size_t k = 0; k < outliers; ++k) {
    std::swap(order[k], order[k + random.index(order.size() - k)]);
    const std::size_t i = order[k], j = random.index(options.pairs);
    problem.inlier[i] = false;
    target[i] = clean[j];
    target_normals[i] = clean_normals[j];
    if (options.box_outliers) {
      for (int a = 0; a < 3; ++a) target[i][a] = random.uniform(box.min()[a], box.max()[a]);
      target_normals[i] = random.unit_vector();
    }
  }
  if (!options.normals) source_normals.clear();
  return problem;
}

inline double rotation_error_deg(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return rotation_distance(a.linear(), b.linear()) * 180 / std::numbers::pi;
}

/// At the surface's centre, which is the source frame's origin.
inline double translation_error_mm(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return 1e3 * (a.translation() - b.translation()).norm();
}

}  // namespace palpate::registration::testing
