// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>

#include "palpate/tactile/normals/normal_estimator.hpp"
#include "tactile/normals/filters.hpp"
#include "tactile/normals/lift_detector.hpp"

namespace palpate::tactile {

struct PlaneFitOptions {
  double window = 0.5;        ///< s
  double forget_after = 0.5;  ///< s without contact

  template <class Visitor>
  void visit(Visitor&& v) {
    v("window", window, 0.0, 1e3, "s, length of the window of contact points");
    v("forget_after", forget_after, 0.0, 1e6,
      "s without contact after which the estimate starts again");
  }
};

/// Total least squares: the plane nearest to the contact points of a window. The covariance takes
/// the points' scatter off the plane for noise (Kanatani 1996, plane fitting): on a curved path, or
/// where that noise is not small against the window's way, it is too small.
class PlaneFitEstimator final : public NormalEstimator {
 public:
  /// @throws BadInput for options out of range
  explicit PlaneFitEstimator(const PlaneFitOptions& options = {});
  NormalEstimate update(const FingerSample& sample) override;

 private:
  void start();
  void fit(const Eigen::Vector3d& f);

  PlaneFitOptions options_;
  LiftDetector lifts_;
  std::deque<FingerSample> window_;
  std::optional<Eigen::Vector3d> n_;
  std::optional<Eigen::Matrix3d> covariance_;
};

struct EigenvectorOptions {
  double distance = 0.003;    ///< m of path after which evidence has faded to 1/e
  int low_pass = 15;          ///< samples whose mean velocity is used
  double force_weight = 1.0;  ///< of force x sliding against sliding
  double forget_after = 0.5;  ///< s without contact

  template <class Visitor>
  void visit(Visitor&& v) {
    v("distance", distance, 1e-5, 1.0, "m, path length after which evidence has decayed to 1/e");
    v("low_pass", low_pass, 1, 10000, "number of samples over which the velocity is averaged");
    v("force_weight", force_weight, 0.0, 1e3,
      "weight of force x sliding relative to that of sliding");
    v("forget_after", forget_after, 0.0, 1e6,
      "s without contact after which the estimate starts again");
  }
};

/// The direction least like the directions of sliding and of force x sliding: the eigenvector of
/// the least eigenvalue of their sum of squares, which is where the gradient law of eqs 5.5-5.8
/// would settle. Discounted by distance rather than time.
class EigenvectorEstimator final : public NormalEstimator {
 public:
  /// @throws BadInput for options out of range
  explicit EigenvectorEstimator(const EigenvectorOptions& options = {});
  NormalEstimate update(const FingerSample& sample) override;

 private:
  void start();
  void learn(const FingerSample& sample, double dt);

  EigenvectorOptions options_;
  LiftDetector lifts_;
  RollingMean low_pass_;
  Eigen::Matrix3d squares_ = Eigen::Matrix3d::Zero();
  std::optional<FingerSample> last_;
  std::optional<Eigen::Vector3d> n_;
};

}  // namespace palpate::tactile
