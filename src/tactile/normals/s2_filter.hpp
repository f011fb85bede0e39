// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "palpate/tactile/normals/normal_estimator.hpp"
#include "tactile/normals/lift_detector.hpp"
#include "tactile/normals/noise_meter.hpp"

namespace palpate::tactile {

/// What the filter believes of surfaces and motions. The sensors' noise it measures itself.
struct S2Options {
  double tilt_rate = 0.02;       ///< rad/sqrt(s), of the normal on a face
  double roll_tilt_rate = 0.6;   ///< rad/sqrt(s), where the tip rolls around something
  double edge_tilt_rate = 1.5;   ///< rad/sqrt(s), across an edge
  double curvature_rate = 5;     ///< 1/m/sqrt(s), of the surface along the way
  double acceleration = 0.05;    ///< m/s^2, of the sliding point at first; then it is learnt
  double min_ratio_rate = 0.1;   ///< 1/sqrt(s), of tangential to normal force; more is learnt
  double turn_ratio_rate = 3;    ///< 1/sqrt(s), of the same where sliding changes direction
  double turn_acceleration = 3;  ///< times as much acceleration there
  double coupling = 0.4;         ///< by how much friction need not oppose sliding, of normal force
  double roll_share = 0.012;     ///< probability that within 10 ms the tip begins to roll,
  double edge_share = 0.005;     ///< crosses an edge,
  double turn_share = 0.005;     ///< turns
  double stay = 0.9;             ///< probability that the next 10 ms go on with it
  double forget_after = 0.5;     ///< s without contact after which to start again
  double lag = 0.2;              ///< s, that S2Smoother's estimates wait for later samples

  template <class Visitor>
  void visit(Visitor&& v) {
    v("tilt_rate", tilt_rate, 0.0, 10.0, "rad/sqrt(s), change of the normal on a face");
    v("roll_tilt_rate", roll_tilt_rate, 0.0, 10.0,
      "rad/sqrt(s), change of the normal where the tip rolls");
    v("edge_tilt_rate", edge_tilt_rate, 0.0, 100.0,
      "rad/sqrt(s), change of the normal across an edge");
    v("curvature_rate", curvature_rate, 0.0, 1e3,
      "1/m/sqrt(s), change of the surface's curvature along the path");
    v("acceleration", acceleration, 1e-6, 1e3, "m/s^2, initial acceleration of the sliding point");
    v("min_ratio_rate", min_ratio_rate, 0.0, 1e3,
      "1/sqrt(s), change of the ratio of tangential to normal force, at least");
    v("turn_ratio_rate", turn_ratio_rate, 0.0, 1e3, "1/sqrt(s), change of that ratio in a turn");
    v("turn_acceleration", turn_acceleration, 1.0, 1e3, "factor on the acceleration in a turn");
    v("coupling", coupling, 1e-6, 1e3,
      "deviation of friction from the sliding direction, relative to the normal force");
    v("roll_share", roll_share, 1e-9, 0.3, "probability that the tip begins to roll within 10 ms");
    v("edge_share", edge_share, 1e-9, 0.3, "probability that it crosses an edge within 10 ms");
    v("turn_share", turn_share, 1e-9, 0.3, "probability that it turns within 10 ms");
    v("stay", stay, 0.0, 0.999, "probability that the present motion continues for 10 ms");
    v("forget_after", forget_after, 0.0, 1e6,
      "s without contact after which the estimate starts again");
    v("lag", lag, 0.0, 10.0, "s, delay of smoothed estimates");
  }
};

/// Extended Kalman filter of the contact normal on S2, fed by force, sliding and tip geometry.
///
/// The state is a frame (two tangents and the normal), the ratio of tangential to normal force and
/// the velocity of the contact in that frame, its place, and the surface's curvature along the way.
/// A force measures the normal together with that ratio, which turns slowly and points along the
/// sliding; the place measures the velocity, which has no part along the normal; the tip's shape
/// measures the normal itself. Four hypotheses of what the tick was (slid on a face, crossed an
/// edge, turned, rolled) are tried and merged at every tick (generalised pseudo-Bayes of first
/// order, Blom & Bar-Shalom 1988), so that the normal is quick over edges and calm on faces. Noise
/// of point, force and tip is measured from the samples, the change of the force's ratio and of the
/// velocity from the innovations.
class S2Filter final : public NormalEstimator {
 public:
  static constexpr std::size_t kHypotheses = 4;
  /// The random walk that keeps the filter awake is not there while the tip slides on a face: the
  /// error of a gain K has then the variance P / (2 - K), about half, but edges may have gone
  /// unnoticed. Share of the covariance by which it is reported smaller; calibrated on tuning
  /// seeds.
  static constexpr double kStillness = 0.4;

  /// How the last update led from one normal to the next, for smoothing.
  struct Step {
    Eigen::Matrix3d R_predicted;                          ///< tangents and normal
    std::array<Eigen::Matrix2d, kHypotheses> covariance;  ///< of the predicted normal's tilt
    std::array<double, kHypotheses> weight;               ///< of the hypotheses, afterwards
    bool anew = true;                                     ///< it did not follow the one before
    double stillness = 0;  ///< share by which the covariance is reported smaller
  };

  /// @throws BadInput for options out of range
  explicit S2Filter(const S2Options& options = {});
  NormalEstimate update(const FingerSample& sample) override;

  [[nodiscard]] const Step& last_step() const { return step_; }
  [[nodiscard]] const Eigen::Matrix3d& frame() const { return R_; }
  /// Of the normal's tilt towards the frame's two tangents, rad^2.
  [[nodiscard]] Eigen::Matrix2d tilt_covariance() const { return P_.topLeftCorner<2, 2>(); }

 private:
  static constexpr int kSize = 10;  // tilt 2, ratio 2, velocity 2, place 3, curvature 1
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  /// One number measured: residual = h x + noise.
  struct Row {
    Vector h;
    double residual = 0, variance = 0;
    bool may_be_outlier = false;
  };
  using Rows = std::vector<Row>;

  /// What one hypothesis makes of a tick.
  struct Belief {
    Vector x = Vector::Zero();
    Matrix P;
    double log_weight = 0;
  };

  void start(const FingerSample& sample);
  bool lost(const FingerSample& sample) const;
  void predict(double dt);
  void measure(const FingerSample& sample);
  void measure_force(const Eigen::Vector3d& f);
  void measure_tip(const Eigen::Vector3d& tip_normal);
  void follow_slide(double dt);
  void measure_friction();
  void learn_ratio_rate(double dt);
  void learn_acceleration(const Eigen::Vector3d& p);
  std::array<Vector, kHypotheses> process_variances(double dt) const;
  std::array<double, kHypotheses> prior(double dt) const;
  Belief explain(const Vector& process_variance, double prior) const;
  void merge(const std::array<Belief, kHypotheses>& beliefs);
  void retract(const Vector& x);
  double tip_lag_variance() const;
  void inflate_covariance(const Eigen::Vector3d& tip_normal);
  Eigen::Matrix2d missed_turn() const;
  NormalEstimate estimate(double time, NormalStatus status) const;

  S2Options options_;
  LiftDetector lifts_;
  NoiseMeter force_noise_, point_noise_, tip_noise_;
  bool started_ = false;
  double time_ = 0;
  Eigen::Matrix3d R_ = Eigen::Matrix3d::Identity();  // columns: two tangents, outward normal
  Eigen::Vector2d ratio_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity_ = Eigen::Vector2d::Zero();
  Eigen::Vector3d p_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d behind_ = Eigen::Vector3d::Zero();  // place, averaged over kSlideTime
  bool slides_ = false;                               // by more than the point's noise
  bool measured_ = false;                             // by sliding or tip, since the start
  double curvature_ = 0;
  Matrix P_ = Matrix::Zero();
  double ratio_variance_ = 1e-3;
  double acceleration_;                             // m/s^2, learnt
  Eigen::Vector2d slip_ = Eigen::Vector2d::Zero();  // last innovation of the place
  double slip_variance_;
  std::array<double, kHypotheses> weight_{};
  Eigen::Vector2d tip_lag_ = Eigen::Vector2d::Zero();  // of the normal behind the tip's, averaged
  Rows rows_;
  Step step_;
};

}  // namespace palpate::tactile
