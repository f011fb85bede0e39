// SPDX-License-Identifier: Apache-2.0
#include "learning/demonstrations/pnp.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::learning {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix2Xd;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kDraw = 6;      // matches that determine a projection
constexpr double kDegenerate = 1e-3;  // least singular value of a rotation, of its largest
constexpr int kConsensusRounds = 5;   // of refining and collecting those that agree

/// Reprojection error of one match, pixels; infinite behind the camera.
Vector2d reprojection(const PinholeCamera& camera, const Isometry3d& T, const Vector3d& point,
                      const Vector2d& pixel) {
  const Vector3d p = T * point;
  if (!(p.z() > 0)) return Vector2d::Constant(std::numeric_limits<double>::infinity());
  return camera.project(p) - pixel;
}

/// Pose by the direct linear transform; none if the matches do not determine it.
std::optional<Isometry3d> linear_pose(const PinholeCamera& camera, const Matrix3Xd& points,
                                      const Matrix2Xd& pixels, const std::vector<int>& chosen) {
  // Points about their center, in units of their spread, so that the system is well scaled.
  Vector3d center = Vector3d::Zero();
  for (const int i : chosen) center += points.col(i) / static_cast<double>(chosen.size());
  double spread = 0;
  for (const int i : chosen) spread = std::max(spread, (points.col(i) - center).norm());
  if (!(spread > 0)) return {};
  Eigen::Matrix<double, Eigen::Dynamic, 12> A(2 * std::ssize(chosen), 12);
  A.setZero();
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const Eigen::RowVector4d X = ((points.col(chosen[k]) - center) / spread).homogeneous();
    const Vector3d ray = camera.ray(pixels.col(chosen[k]));
    const auto row = 2 * static_cast<Index>(k);
    A.block<1, 4>(row, 0) = X;
    A.block<1, 4>(row, 8) = -ray.x() * X;
    A.block<1, 4>(row + 1, 4) = X;
    A.block<1, 4>(row + 1, 8) = -ray.y() * X;
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeFullV);
  const Eigen::Matrix<double, 3, 4> P =
      Eigen::Matrix<double, 4, 3>::Map(svd.matrixV().col(11).eval().data()).transpose();
  const Eigen::JacobiSVD<Matrix3d> rotation(P.leftCols<3>(),
                                            Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector3d sizes = rotation.singularValues();
  if (!(sizes[2] > kDegenerate * sizes[0])) return {};
  const Matrix3d UV = rotation.matrixU() * rotation.matrixV().transpose();
  const double sign = UV.determinant() < 0 ? -1 : 1;
  Isometry3d T;
  T.linear() = sign * UV;
  const Vector3d at_center = sign * P.col(3) * spread / sizes.mean();
  T.translation() = at_center - T.linear() * center;
  return T;
}

/// Gauss-Newton steps on the reprojection error, as long as it falls.
Isometry3d refine(const PinholeCamera& camera, const Matrix3Xd& points, const Matrix2Xd& pixels,
                  const std::vector<int>& chosen, Isometry3d T, int iterations) {
  const auto cost = [&](const Isometry3d& pose) {
    double sum = 0;
    for (const int i : chosen) {
      sum += reprojection(camera, pose, points.col(i), pixels.col(i)).squaredNorm();
    }
    return sum;
  };
  double before = cost(T);
  for (int step = 0; step < iterations && std::isfinite(before); ++step) {
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    for (const int i : chosen) {
      const Vector3d p = T * points.col(i);
      Eigen::Matrix<double, 2, 3> projection;
      projection << 1, 0, -p.x() / p.z(), 0, 1, -p.y() / p.z();
      Eigen::Matrix<double, 3, 6> motion;
      motion << -skew(p), Matrix3d::Identity();
      const Eigen::Matrix<double, 2, 6> J = camera.focal / p.z() * projection * motion;
      H += J.transpose() * J;
      g += J.transpose() * reprojection(camera, T, points.col(i), pixels.col(i));
    }
    const Isometry3d next = exp_se3(-H.ldlt().solve(g)) * T;
    const double after = cost(next);
    if (!(after < before)) break;
    T = next;
    before = after;
  }
  return T;
}

std::vector<int> agreeing(const PinholeCamera& camera, const Matrix3Xd& points,
                          const Matrix2Xd& pixels, const Isometry3d& T, double threshold) {
  std::vector<int> result;
  for (int i = 0; i < points.cols(); ++i) {
    if (reprojection(camera, T, points.col(i), pixels.col(i)).norm() < threshold) {
      result.push_back(i);
    }
  }
  return result;
}

std::vector<int> draw(int count, RandomStream& random) {
  std::vector<int> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), 0);
  for (std::size_t i = 0; i < kDraw; ++i) {
    std::swap(all[i], all[i + random.index(all.size() - i)]);
  }
  all.resize(kDraw);
  return all;
}

void check(const Matrix3Xd& points, const Matrix2Xd& pixels) {
  if (points.cols() != pixels.cols()) {
    throw BadInput(fmt::format("{} points matched with {} pixels", points.cols(), pixels.cols()));
  }
  if (!points.allFinite() || !pixels.allFinite()) {
    throw BadInput("matches of points with pixels that are not finite");
  }
}

}  // namespace

PnpResult solve_pnp(const PinholeCamera& camera, const Matrix3Xd& points, const Matrix2Xd& pixels,
                    const PnpOptions& options, std::uint64_t seed) {
  check(points, pixels);
  PnpResult result;
  const int count = static_cast<int>(points.cols());
  if (count < options.min) {
    result.status = PnpStatus::too_few_matches;
    return result;
  }
  RandomStream random(seed, "pnp");
  for (int trial = 0; trial < options.draws; ++trial) {
    const auto T = linear_pose(camera, points, pixels, draw(count, random));
    if (!T) continue;
    auto inliers = agreeing(camera, points, pixels, *T, options.threshold);
    if (inliers.size() <= result.inliers.size()) continue;
    result.inliers = std::move(inliers);
    result.T_camera_object = *T;
  }
  for (int round = 0; round < kConsensusRounds && result.inliers.size() >= kDraw; ++round) {
    result.T_camera_object =
        refine(camera, points, pixels, result.inliers, result.T_camera_object, options.iterations);
    result.inliers = agreeing(camera, points, pixels, result.T_camera_object, options.threshold);
  }
  if (std::ssize(result.inliers) < options.min) {
    result.status = PnpStatus::no_consensus;
    return result;
  }
  double sum = 0;
  for (const int i : result.inliers) {
    sum += reprojection(camera, result.T_camera_object, points.col(i), pixels.col(i)).squaredNorm();
  }
  result.rms = std::sqrt(sum / static_cast<double>(result.inliers.size()));
  return result;
}

}  // namespace palpate::learning
