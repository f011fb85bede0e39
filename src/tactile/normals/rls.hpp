// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/tactile/normals/normal_estimator.hpp"
#include "tactile/normals/filters.hpp"
#include "tactile/normals/lift_detector.hpp"

namespace palpate::tactile {

/// Options of the recursive least squares of thesis 5.1.1.
struct RlsOptions {
  /// Whether to follow eqs 5.4-5.10 as printed: n0 = v1 x v0, half the angle in 5.10, the force
  /// unscaled, the sign left as it came.
  bool literal = false;
  double decay = 2.0;         ///< beta, 1/s
  double gain = 2e5;          ///< K_L
  double gamma1 = 1.0;        ///< weight of sliding
  double gamma2 = 1.0;        ///< weight of force x sliding
  int low_pass = 15;          ///< samples whose mean velocity is used
  double min_speed = 1e-4;    ///< m/s; slower samples are passed over
  double forget_after = 0.5;  ///< s without contact

  template <class Visitor>
  void visit(Visitor&& v) {
    v("literal", literal, "use the equations as printed");
    v("decay", decay, 0.0, 1e3, "1/s, decay of what has been learnt");
    v("gain", gain, 0.0, 1e9, "gain of the gradient");
    v("gamma1", gamma1, 0.0, 1e3, "weight of sliding");
    v("gamma2", gamma2, 0.0, 1e3, "weight of force x sliding");
    v("low_pass", low_pass, 1, 10000, "number of samples over which the velocity is averaged");
    v("min_speed", min_speed, 0.0, 1.0, "m/s, speed below which samples are ignored");
    v("forget_after", forget_after, 0.0, 1e6,
      "s without contact after which the estimate starts again");
  }
};

/// Recursive least squares: the normal turns down the gradient of its squared products with the
/// sliding velocity and with force x velocity (eqs 5.1-5.10; a gradient law). The velocity of the
/// centroid is measured, so that eq. 5.2 has nothing to add to it.
class RlsEstimator final : public NormalEstimator {
 public:
  /// @throws BadInput for options out of range
  explicit RlsEstimator(const RlsOptions& options = {});
  NormalEstimate update(const FingerSample& sample) override;

 private:
  void forget();
  void start(const FingerSample& sample, const Eigen::Vector3d& v);
  void learn(const Eigen::Vector3d& f, const Eigen::Vector3d& v, double dt);
  void turn(const Eigen::Vector3d& f, double dt);

  RlsOptions options_;
  LiftDetector lifts_;
  RollingMean low_pass_;
  Eigen::Matrix3d L1_ = Eigen::Matrix3d::Zero(), L2_ = Eigen::Matrix3d::Zero();
  std::optional<FingerSample> last_;
  std::optional<Eigen::Vector3d> last_v_;
  std::optional<Eigen::Vector3d> n_;
};

}  // namespace palpate::tactile
