// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "palpate/learning/demonstrations/camera.hpp"

namespace palpate::learning {

struct PnpOptions {
  double threshold = 4;  ///< pixels, of a match that counts
  int draws = 200;       ///< of six matches each
  int min = 8;           ///< matches that must agree
  int iterations = 20;   ///< of the refinement

  template <class Visitor>
  void visit(Visitor&& v) {
    v("threshold", threshold, 0.01, 1000.0, "pixels, of a match that counts");
    v("draws", draws, 1, 1000000, "of six matches each");
    v("min", min, 6, 1000000, "matches that must agree");
    v("iterations", iterations, 0, 1000, "of the refinement");
  }
};

enum class PnpStatus { ok, too_few_matches, no_consensus };

struct PnpResult {
  PnpStatus status = PnpStatus::ok;
  Eigen::Isometry3d T_camera_object = Eigen::Isometry3d::Identity();
  double rms = 0;            ///< pixels, of the inliers
  std::vector<int> inliers;  ///< indices of the matches
};

/// Pose of an object from matches of its points (3 x n, m) with pixels (2 x n), some of them wrong
/// (thesis 7.2.2). Six matches at a time give a pose by the direct linear transform (Hartley &
/// Zisserman 2004, 7.1); the one that most agree with is refined by Gauss-Newton steps on their
/// reprojection error. The points must not lie in one plane.
/// @throws BadInput if sizes differ or a value is not finite
PnpResult solve_pnp(const PinholeCamera& camera, const Eigen::Matrix3Xd& points,
                    const Eigen::Matrix2Xd& pixels, const PnpOptions& options = {},
                    std::uint64_t seed = 0);

}  // namespace palpate::learning
