// SPDX-License-Identifier: Apache-2.0
#include "tactile/normals/s2_filter.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/core/option_check.hpp"
#include "palpate/core/se3.hpp"
#include "tactile/normals/estimate_status.hpp"

namespace palpate::tactile {
namespace {

constexpr double kMemory = 100;  // samples that noise is averaged over

// Before anything was measured, per axis.
constexpr double kForceNoise = 0.05, kMinForceNoise = 1e-3;  // N
constexpr double kPointNoise = 3e-4, kMinPointNoise = 1e-6;  // m
constexpr double kTipNoise = 0.1, kMinTipNoise = 0.01;       // rad
constexpr double kStartTilt = 0.5;                           // rad
constexpr double kStartRatio = 0.5;
constexpr double kStartSpeed = 0.03;    // m/s
constexpr double kStartPlace = 1e-3;    // m
constexpr double kStartCurvature = 20;  // 1/m
constexpr double kShareTime = 0.01;     // s, that the options' shares refer to
constexpr double kMaxOthers = 0.9;      // prior of all hypotheses but the first, after a long dt
constexpr double kStartShare = 0.05;    // of each hypothesis but the first

constexpr double kMinPress = 0.2;    // of a force along the normal; less means to be lost
constexpr double kGate = 6;          // squared innovation over its variance of a usual outlier
constexpr double kJump = 9;          // squared innovation over its variance of no usual tick
constexpr double kSlides = 2;        // speed over its uncertainty
constexpr double kSlideTime = 0.25;  // s
constexpr double kSlideGate = 5;     // way in that time over its uncertainty
constexpr double kMinSpeed = 1e-4;   // m/s

// Tip normals are too noisy for one of them to show that the normal turned unnoticed, but their
// mean over some ticks is not. 1 % of the time it is as far off as kLagGate by chance (chi2, 2
// dof).
constexpr double kTipMemory = 8;   // samples
constexpr double kLagGate = 9.21;  // squared length over its variance of the mean residual

// How fast the acceleration is learnt from correlated innovations, per sample, and its bounds.
constexpr double kAccelerationRate = 0.02;
constexpr double kMinAcceleration = 0.01, kMaxAcceleration = 0.5;  // m/s^2
constexpr double kSlipMemory = 200;                                // samples
constexpr double kMaxCorrelation = 3;                              // of one pair of innovations

// Indices of the state.
constexpr int kTilt = 0, kRatio = 2, kVelocity = 4, kPlace = 6, kCurvature = 9;

/// Rotation vector, in the frame, that tilts its normal by d towards its two tangents.
Eigen::Vector3d turn_of(const Eigen::Vector2d& d) { return {-d.y(), d.x(), 0}; }

double squared(double x) { return x * x; }

}  // namespace

S2Filter::S2Filter(const S2Options& options)
    : options_(checked(options)),
      lifts_(options.forget_after),
      force_noise_(3, kForceNoise, kMinForceNoise, kMemory),
      point_noise_(3, kPointNoise, kMinPointNoise, kMemory),
      tip_noise_(2, kTipNoise, kMinTipNoise, kMemory),
      acceleration_(options.acceleration),
      slip_variance_(2 * squared(kPointNoise)) {}

void S2Filter::start(const FingerSample& sample) {
  R_ = frame_with_z(sample.tip_normal.value_or(-sample.f.normalized()));
  ratio_.setZero();
  velocity_.setZero();
  p_ = sample.p;
  behind_ = sample.p;
  curvature_ = 0;
  Vector sigma;
  sigma << kStartTilt, kStartTilt, kStartRatio, kStartRatio, kStartSpeed, kStartSpeed, kStartPlace,
      kStartPlace, kStartPlace, kStartCurvature;
  P_ = sigma.cwiseAbs2().asDiagonal();
  weight_.fill(kStartShare);
  weight_[0] = 1 - kStartShare * (kHypotheses - 1);
  step_.anew = true;
  step_.stillness = 0;
  slides_ = false;
  measured_ = sample.tip_normal.has_value();
  tip_lag_.setZero();
  slip_.setZero();
  started_ = true;
}

/// Whether the force pulls at the surface as believed: then it is another one.
bool S2Filter::lost(const FingerSample& sample) const {
  return R_.col(2).dot(sample.f) > -kMinPress * sample.f.norm();
}

void S2Filter::predict(double dt) {
  const Eigen::Matrix<double, 3, 2> B = R_.leftCols<2>();
  Matrix F = Matrix::Identity();
  if (slides_) F.block<3, 2>(kPlace, kTilt) = -dt * R_.col(2) * velocity_.transpose();
  F.block<3, 2>(kPlace, kVelocity) = dt * B;
  F.block<2, 2>(kTilt, kVelocity).diagonal().setConstant(dt * curvature_);
  F.block<2, 1>(kTilt, kCurvature) = dt * velocity_;
  P_ = (F * P_ * F.transpose()).eval();
  p_ += dt * B * velocity_;
  R_ = R_ * exp_so3(turn_of(dt * curvature_ * velocity_));
}

/// The ratio of tangential to normal force, from the force in the frame, along and across itself.
void S2Filter::measure_force(const Eigen::Vector3d& f) {
  const Eigen::Vector3d g = R_.transpose() * f;
  const Eigen::Vector2d z = g.head<2>() / -g.z();
  const double variance = squared(force_noise_.sigma() / g.z());
  const Eigen::Vector2d along =
      z.norm() > 1e-6 ? Eigen::Vector2d(z.normalized()) : Eigen::Vector2d::UnitX();
  const Eigen::Vector2d across(-along.y(), along.x());
  const double lean = 1 + z.squaredNorm();
  Row row{.h = Vector::Zero()};
  row.h.segment<2>(kTilt) = -lean * along;
  row.h.segment<2>(kRatio) = along;
  row.residual = along.dot(z - ratio_);
  row.variance = variance * lean;
  rows_.push_back(row);
  row.h.segment<2>(kTilt) = -across;
  row.h.segment<2>(kRatio) = across;
  row.residual = across.dot(z - ratio_);
  row.variance = variance;
  rows_.push_back(row);
}

void S2Filter::measure_tip(const Eigen::Vector3d& tip_normal) {
  const Eigen::Vector3d t = R_.transpose() * tip_normal;
  for (int i = 0; i < 2; ++i) {
    Row row{.h = Vector::Zero(), .may_be_outlier = true};
    row.h[kTilt + i] = 1;
    row.residual = t[i] / std::max(t.z(), kMinPress);
    row.variance = squared(tip_noise_.sigma());
    rows_.push_back(row);
  }
}

/// Whether the point moves by more than its noise: over kSlideTime, because in every tick the noise
/// alone looks like a velocity.
void S2Filter::follow_slide(double dt) {
  behind_ += -std::expm1(-dt / kSlideTime) * (p_ - behind_);
  const Eigen::Vector2d way = R_.leftCols<2>().transpose() * (p_ - behind_);
  slides_ = way.norm() > kSlideGate * std::sqrt(P_.block<3, 3>(kPlace, kPlace).trace());
  measured_ = measured_ || slides_;
}

/// Friction is along the sliding, where there is any: ratio x velocity / speed = 0.
void S2Filter::measure_friction() {
  if (!slides_) return;
  const double speed = velocity_.norm();
  if (speed < kSlides * std::sqrt(P_.block<2, 2>(kVelocity, kVelocity).trace())) return;
  const Eigen::Vector2d u = velocity_ / speed;
  const double cross = ratio_.x() * u.y() - ratio_.y() * u.x();
  Row row{.h = Vector::Zero(), .may_be_outlier = true};
  row.h.segment<2>(kRatio) << u.y(), -u.x();
  row.h.segment<2>(kVelocity) << (-ratio_.y() - cross * u.x()) / speed,
      (ratio_.x() - cross * u.y()) / speed;
  row.residual = -cross;
  row.variance = squared(options_.coupling);
  rows_.push_back(row);
}

void S2Filter::measure(const FingerSample& sample) {
  rows_.clear();
  measure_force(sample.f);
  if (sample.tip_normal) measure_tip(*sample.tip_normal);
  for (int i = 0; i < 3; ++i) {
    Row row{.h = Vector::Zero(), .may_be_outlier = true};
    row.h[kPlace + i] = 1;
    row.residual = sample.p[i] - p_[i];
    row.variance = squared(point_noise_.sigma());
    rows_.push_back(row);
  }
  measure_friction();
}

/// Learns how much the ratio changes in a tick from what its measurements differ beyond their noise
/// and the state's uncertainty.
void S2Filter::learn_ratio_rate(double dt) {
  double excess = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const Row& row = rows_[i];
    const double expected = row.variance + row.h.dot(P_ * row.h);
    const double usual = kJump * (expected + ratio_variance_);
    excess += 0.5 * (std::min(squared(row.residual), usual) - expected);
  }
  const double share = weight_[0] / kMemory;
  ratio_variance_ += share * (excess - ratio_variance_);
  ratio_variance_ = std::clamp(ratio_variance_, squared(options_.min_ratio_rate) * dt,
                               squared(options_.turn_ratio_rate) * dt);
}

/// Learns how much the sliding accelerates: the innovations of the place along the surface are
/// uncorrelated from one tick to the next where the process noise is right, and follow each other
/// where it is too small (Mehra 1970).
void S2Filter::learn_acceleration(const Eigen::Vector3d& p) {
  const Eigen::Vector2d slip = R_.leftCols<2>().transpose() * (p - p_);
  slip_variance_ += (slip.squaredNorm() - slip_variance_) / kSlipMemory;
  const double correlation =
      std::clamp(slip.dot(slip_) / slip_variance_, -kMaxCorrelation, kMaxCorrelation);
  acceleration_ = std::clamp(acceleration_ * std::exp(kAccelerationRate * correlation),
                             kMinAcceleration, kMaxAcceleration);
  slip_ = slip;
}

/// What each hypothesis adds to the state's variances in a tick: face, edge, turn, roll.
std::array<S2Filter::Vector, S2Filter::kHypotheses> S2Filter::process_variances(double dt) const {
  // The velocity is modelled as a random walk, but changes steadily over the time T that the filter
  // needs to see it change: q = a sqrt(T), T^4 = point variance dt / q^2.
  const double q = std::pow(acceleration_, 0.8) * std::pow(squared(point_noise_.sigma()) * dt, 0.1);
  const double turning = ratio_.norm() * q / std::max(velocity_.norm(), kMinSpeed);
  const double ratio =
      std::min(std::sqrt(ratio_variance_ / dt + squared(turning)), options_.turn_ratio_rate);
  const auto variances = [&](double tilt_rate, double ratio_rate, double velocity_rate) {
    Vector v = Vector::Zero();
    v.segment<2>(kTilt).setConstant(squared(tilt_rate) * dt);
    v.segment<2>(kRatio).setConstant(squared(ratio_rate) * dt);
    v.segment<2>(kVelocity).setConstant(squared(velocity_rate) * dt);
    v[kCurvature] = squared(options_.curvature_rate) * dt;
    return v;
  };
  Vector turn =
      variances(options_.tilt_rate, options_.turn_ratio_rate, options_.turn_acceleration * q);
  turn.segment<2>(kVelocity).array() += velocity_.squaredNorm();  // a sharp one, within a tick
  return {variances(options_.tilt_rate, ratio, q), variances(options_.edge_tilt_rate, ratio, q),
          turn, variances(options_.roll_tilt_rate, ratio, q)};
}

/// Probabilities of the hypotheses before the tick's measurements.
std::array<double, S2Filter::kHypotheses> S2Filter::prior(double dt) const {
  const double steps = dt / kShareTime;
  const double stay = std::pow(options_.stay, steps);
  const auto share = [&](double p) { return -std::expm1(steps * std::log1p(-p)); };
  const double leaving = weight_[0] + (1 - stay) * (1 - weight_[0]);
  std::array<double, kHypotheses> result = {0, share(options_.edge_share),
                                            share(options_.turn_share), share(options_.roll_share)};
  const double others = result[1] + result[2] + result[3];
  for (double& p : result) p *= std::min(1.0, kMaxOthers / others);
  result[0] = 1 - std::min(others, kMaxOthers);
  for (std::size_t k = 0; k < kHypotheses; ++k) {
    result[k] = result[k] * leaving + (k > 0 ? stay * weight_[k] : 0);
  }
  return result;
}

S2Filter::Belief S2Filter::explain(const Vector& process_variance, double prior) const {
  Belief belief{.P = P_, .log_weight = std::log(prior)};
  belief.P.diagonal() += process_variance;
  for (const Row& row : rows_) {
    const Vector Ph = belief.P * row.h;
    const double innovation = row.residual - row.h.dot(belief.x);
    double variance = row.h.dot(Ph) + row.variance;
    if (row.may_be_outlier) variance = std::max(variance, squared(innovation) / kGate);
    belief.log_weight -= 0.5 * (squared(innovation) / variance + std::log(variance));
    belief.x += Ph * (innovation / variance);
    belief.P -= Ph * Ph.transpose() / variance;
  }
  return belief;
}

/// Merges the hypotheses' beliefs into one of the same mean and covariance.
void S2Filter::merge(const std::array<Belief, kHypotheses>& beliefs) {
  double top = beliefs[0].log_weight, sum = 0;
  for (const Belief& belief : beliefs) top = std::max(top, belief.log_weight);
  for (std::size_t k = 0; k < kHypotheses; ++k) {
    weight_[k] = std::exp(beliefs[k].log_weight - top);
    sum += weight_[k];
  }
  Vector mean = Vector::Zero();
  for (std::size_t k = 0; k < kHypotheses; ++k) {
    weight_[k] /= sum;
    mean += weight_[k] * beliefs[k].x;
  }
  P_.setZero();
  for (std::size_t k = 0; k < kHypotheses; ++k) {
    const Vector d = beliefs[k].x - mean;
    P_ += weight_[k] * (beliefs[k].P + d * d.transpose());
  }
  retract(mean);
}

void S2Filter::retract(const Vector& x) {
  R_ = R_ * exp_so3(turn_of(x.segment<2>(kTilt)));
  ratio_ += x.segment<2>(kRatio);
  velocity_ += x.segment<2>(kVelocity);
  p_ += x.segment<3>(kPlace);
  curvature_ += x[kCurvature];
}

/// Variance per axis that the tip's averaged residual has by chance.
double S2Filter::tip_lag_variance() const {
  return squared(tip_noise_.sigma()) / (2 * kTipMemory - 1) + 0.5 * tilt_covariance().trace();
}

/// Where the normal turns slowly under the tip, the force takes it for a change of the ratio, and
/// only the tip's shape shows it, a little in every tick. If its normals stay aside of the
/// estimate, the state becomes as uncertain as that: of tilt and ratio together, which the force
/// cannot distinguish.
void S2Filter::inflate_covariance(const Eigen::Vector3d& tip_normal) {
  const Eigen::Vector3d t = R_.transpose() * tip_normal;
  tip_lag_ += (t.head<2>() / std::max(t.z(), kMinPress) - tip_lag_) / kTipMemory;
  if (tip_lag_.squaredNorm() < kLagGate * tip_lag_variance()) return;
  Vector lag = Vector::Zero();
  lag.segment<2>(kTilt) = tip_lag_;
  lag.segment<2>(kRatio) = tip_lag_ + ratio_ * ratio_.dot(tip_lag_);
  P_ += lag * lag.transpose();
}

/// What the tip's averaged residual shows beyond chance: a turn that the state has missed (matching
/// the covariance to the innovations, Mehra 1972).
Eigen::Matrix2d S2Filter::missed_turn() const {
  const double chance = 2 * tip_lag_variance();
  const double square = tip_lag_.squaredNorm();
  if (square <= chance) return Eigen::Matrix2d::Zero();
  return (1 - chance / square) * tip_lag_ * tip_lag_.transpose();
}

NormalEstimate S2Filter::estimate(double time, NormalStatus status) const {
  if (!started_) return estimate_of(time, status, {}, {});
  // A normal that is not measured may roll away.
  const double unseen = squared(options_.roll_tilt_rate) * std::max(0.0, time - time_);
  const double still = 1 - step_.stillness;
  const Eigen::Matrix2d P =
      still * tilt_covariance() + missed_turn() + unseen * Eigen::Matrix2d::Identity();
  const Eigen::Matrix<double, 3, 2> B = R_.leftCols<2>();
  return estimate_of(time, status, Eigen::Vector3d(R_.col(2)), B * P * B.transpose());
}

NormalEstimate S2Filter::update(const FingerSample& sample) {
  const bool lifted = lifts_.begins(sample);
  if (!sample.flags.usable()) return estimate(sample.time, NormalStatus::held);
  if (lifted) {
    for (NoiseMeter* noise : {&force_noise_, &point_noise_, &tip_noise_}) noise->interrupt();
  }
  force_noise_.add(sample.f);
  point_noise_.add(sample.p);
  if (sample.tip_normal) tip_noise_.add(*sample.tip_normal);
  const double dt = sample.time - time_;
  if (lifted || lost(sample)) {
    start(sample);
  } else {
    predict(dt);
    measure(sample);
    learn_ratio_rate(dt);
    learn_acceleration(sample.p);
    const auto variances = process_variances(dt);
    const auto priors = prior(dt);
    std::array<Belief, kHypotheses> beliefs;
    step_.R_predicted = R_;
    for (std::size_t k = 0; k < kHypotheses; ++k) {
      beliefs[k] = explain(variances[k], priors[k]);
      step_.covariance[k] = tilt_covariance();
      step_.covariance[k].diagonal() += variances[k].segment<2>(kTilt);
    }
    merge(beliefs);
    follow_slide(dt);
    if (sample.tip_normal) inflate_covariance(*sample.tip_normal);
    step_.weight = weight_;
    step_.anew = false;
    step_.stillness = measured_ ? kStillness * weight_[0] : 0;
  }
  time_ = sample.time;
  return estimate(sample.time, NormalStatus::tracked);
}

}  // namespace palpate::tactile
