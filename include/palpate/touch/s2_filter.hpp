// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "palpate/touch/noise_meter.hpp"
#include "palpate/touch/normal_estimator.hpp"

namespace palpate::touch {

struct S2Options {
  double start_sigma = 0.5;
  double tilt_rate = 0.15;      ///< rad/sqrt(s), on a face
  double edge_tilt_rate = 1.5;  ///< rad/sqrt(s), over an edge
  double ratio_rate = 0.1;      ///< 1/sqrt(s), of the ratio of tangential to normal force
  double turn_ratio_rate = 3;
  double acceleration = 0.006;  ///< m/s/sqrt(s)
  double turn_acceleration = 0.03;
  double p_edge = 0.02, p_turn = 0.02, p_stay = 0.8;
  double coupling = 0.15;
  double forget_after = 0.5;
  template <class Visitor>
  void visit(Visitor&& v) {
    v("start_sigma", start_sigma, 0.0, 100.0, "");
    v("tilt_rate", tilt_rate, 0.0, 100.0, "");
    v("edge_tilt_rate", edge_tilt_rate, 0.0, 100.0, "");
    v("ratio_rate", ratio_rate, 0.0, 100.0, "");
    v("turn_ratio_rate", turn_ratio_rate, 0.0, 100.0, "");
    v("acceleration", acceleration, 0.0, 100.0, "");
    v("turn_acceleration", turn_acceleration, 0.0, 100.0, "");
    v("p_edge", p_edge, 0.0, 1.0, "");
    v("p_turn", p_turn, 0.0, 1.0, "");
    v("p_stay", p_stay, 0.0, 1.0, "");
    v("coupling", coupling, 0.0, 100.0, "");
    v("forget_after", forget_after, 0.0, 100.0, "");
  }
};

class S2Filter final : public NormalEstimator {
 public:
  static constexpr int kSize = 9;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  static constexpr int kModes = 3;

  explicit S2Filter(const S2Options& options = {});
  NormalEstimate update(const FingerSample& sample) override;
  std::array<double, 3> modes() const { return {mode_[0], mode_[1], mode_[2]}; }

  struct Row {
    Vector h;
    double residual, variance;
    bool gated;
  };

 private:
  void start(const FingerSample& sample);
  void predict(double dt);
  int measure(const FingerSample& sample, std::array<Row, 8>& rows) const;
  void correct(double dt, const std::array<Row, 8>& rows, int count);
  void retract(const Vector& dx);

  S2Options options_;
  NoiseMeter force_noise_, point_noise_, tip_noise_;
  bool started_ = false;
  double time_ = 0;
  Eigen::Matrix3d R_;  // two tangents and the outward normal
  Eigen::Vector2d m_, c_;
  Eigen::Vector3d p_;
  Matrix P_;
  std::array<double, kModes> mode_{};
};

}  // namespace palpate::touch
