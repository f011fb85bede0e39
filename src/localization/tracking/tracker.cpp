// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/tracking/tracker.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "localization/likelihood/check_evidence.hpp"
#include "localization/likelihood/contact_term.hpp"
#include "localization/likelihood/goodness_of_fit.hpp"
#include "localization/search/pose_family.hpp"
#include "localization/tracking/contact_memory.hpp"
#include "palpate/core/error.hpp"

namespace palpate::localization {
namespace {

constexpr double kContactOffset = 0.003;  // m, as the global search's
constexpr int kIterations = 2;
constexpr double kShortened[] = {1.0, 0.4, 0.15};  // of a step that does not lower the energy
constexpr double kLongestGap = 0.5;                // s without a frame that are trusted
constexpr double kLearningTime = 0.5;              // s over which sliding is averaged
constexpr double kDrift = 1e-4;                    // variance a second, rad^2 and (dm)^2
constexpr double kMinSliding = 0.05;               // share of the velocities' variance
constexpr std::size_t kRecent = 3, kBefore = 25, kSettling = 12;  // frames compared for a slip
constexpr std::size_t kSlipped = 2;     // of the recent ones were surely sensed after it
constexpr std::ptrdiff_t kLearnt = 20;  // frames before it, whose errors are learnt
constexpr std::size_t kMaxFrames = 50;  // that are remembered
constexpr double kLoss = 12;            // of ln weight at which a hypothesis is dropped
constexpr std::size_t kMaxHypotheses = 16;
constexpr PoseTolerance kSamePose{0.026, 0.002};
constexpr double kUnknown = 100;  // rad^2, m^2: variance of a pose of which nothing is known

SearchPose search_pose(const Eigen::Isometry3d& T) {
  return {T.linear().cast<float>(), T.translation().cast<float>()};
}

void check_frame(const TrackFrame& frame) {
  if (frame.velocities.size() != frame.contacts.size()) {
    throw BadInput(fmt::format("tracker: {} velocities for {} contacts", frame.velocities.size(),
                               frame.contacts.size()));
  }
  bool finite = std::isfinite(frame.time);
  for (const auto& velocity : frame.velocities) finite = finite && velocity.allFinite();
  if (!finite) throw BadInput(fmt::format("tracker: the frame at {} s is not finite", frame.time));
}

/// [w; v] that takes one pose to another: R' = exp(w) R, t' = t + v.
Vector6d difference(const Eigen::Isometry3d& to, const Eigen::Isometry3d& from) {
  Vector6d x;
  x << log_so3(to.linear() * from.linear().transpose()), to.translation() - from.translation();
  return x;
}

Eigen::Isometry3d moved(const Eigen::Isometry3d& T, const Vector6d& x) {
  Eigen::Isometry3d result = T;
  result.linear() = exp_so3(x.head<3>()) * T.linear();
  result.translation() += x.tail<3>();
  return result;
}

double log_determinant(const Matrix6d& positive) {
  return 2 * Matrix6d(positive.llt().matrixL()).diagonal().array().log().sum();
}

/// Probability that a vector of this covariance is shorter than `length`: as of a chi-squared
/// variable with the same mean and variance of the squared length (Satterthwaite), whose cube root
/// is nearly normal (Wilson and Hilferty 1931).
double probability_shorter(double length, const Eigen::Matrix3d& covariance) {
  const double mean = covariance.trace(), half_variance = covariance.squaredNorm();
  if (half_variance <= 0) return 1;
  const double freedom = mean * mean / half_variance, spread = 2 / (9 * freedom);
  const double z = (std::cbrt(length * length / mean) - 1 + spread) / std::sqrt(spread);
  return 0.5 * std::erfc(-z / std::numbers::sqrt2);
}

double probability_near(const Matrix6d& covariance) {
  const PoseTolerance near;
  return probability_shorter(near.rotation, covariance.topLeftCorner<3, 3>()) *
         probability_shorter(near.translation, covariance.bottomRightCorner<3, 3>());
}

double mean_of(const std::vector<double>& values, std::size_t first, std::size_t last) {
  double sum = 0;
  for (std::size_t i = first; i < last; ++i) sum += values[i];
  return sum / static_cast<double>(last - first);
}

}  // namespace

Tracker::Tracker(const geometry::ObjectModel& model, const Posterior& start,
                 const TrackerOptions& options, RandomStream random)
    : model_(model),
      options_(options),
      random_(random),
      velocity_variance_(std::pow(options.sliding, 2) / 2 + std::pow(options.velocity_noise, 2)) {
  if (std::ranges::none_of(start.modes, [](const Mode& mode) { return mode.weight > 0; })) {
    throw BadInput(fmt::format(
        "tracker: a posterior of {} modes to start from, none of which has a weight above 0",
        start.modes.size()));
  }
  for (const Mode& mode : start.modes) {
    if (mode.weight <= 0 || hypotheses_.size() == kMaxHypotheses) continue;
    Matrix6d covariance = mode.covariance;
    covariance.diagonal().array() += 1e-8;
    hypotheses_.push_back({mode.T_frame_object, covariance, std::log(mode.weight), mode.free_axis});
  }
  publish();
}

void Tracker::Hypothesis::move_to(const Eigen::Isometry3d& pose) {
  const Eigen::Isometry3d motion = pose * T.inverse();
  T = pose;
  if (!free_axis) return;
  free_axis->point = motion * free_axis->point;
  free_axis->direction = motion.linear() * free_axis->direction;
}

Tracker::TwistFit Tracker::fit_twist(const TrackFrame& frame, const Eigen::Vector3d& about) const {
  Matrix6d H = Matrix6d::Zero();
  H.diagonal() << Eigen::Vector3d::Constant(1 / std::pow(options_.turning, 2)),
      Eigen::Vector3d::Constant(1 / std::pow(options_.moving, 2));
  Vector6d g = Vector6d::Zero();
  for (std::size_t k = 0; k < frame.contacts.size(); ++k) {
    Eigen::Matrix<double, 3, 6> J;
    J << -skew(frame.contacts[k].p - about), Eigen::Matrix3d::Identity();
    H += J.transpose() * J / velocity_variance_;
    g += J.transpose() * frame.velocities[k] / velocity_variance_;
  }
  const Eigen::LLT<Matrix6d> solver(H);
  return {solver.solve(g), solver.solve(Matrix6d::Identity())};
}

/// Sliding keeps for a while, so that what it makes of the twist adds up; the noise of the
/// velocities is another one in every frame.
double Tracker::twist_error_growth(double dt) const {
  const double noise = std::pow(options_.velocity_noise, 2) / velocity_variance_;
  const double sliding = std::max(kMinSliding, 1 - noise);
  return 2 * options_.correlation_time * dt * sliding + dt * dt * noise;
}

/// @param gap  s since the frame before, of which the velocities hold for dt
void Tracker::predict(const TrackFrame& frame, double dt, double gap,
                      Hypothesis& hypothesis) const {
  const TwistFit fit = fit_twist(frame, hypothesis.T.translation());
  hypothesis.move_to(moved(hypothesis.T, dt * fit.twist));
  const double unseen = gap - dt;
  hypothesis.covariance.diagonal().head<3>().array() +=
      std::min(kUnknown, std::pow(options_.turning * unseen, 2));
  hypothesis.covariance.diagonal().tail<3>().array() +=
      std::min(kUnknown, std::pow(options_.moving * unseen, 2));
  hypothesis.covariance += twist_error_growth(dt) * fit.covariance;
  hypothesis.covariance.diagonal().array() +=
      dt * kDrift * (Vector6d() << 1, 1, 1, 0.01, 0.01, 0.01).finished().array();
}

/// What the velocities leave unexplained by a rigid motion shows how much the fingertips slide.
void Tracker::learn_sliding(const TrackFrame& frame, double dt) {
  const auto freedom = 3 * static_cast<double>(frame.contacts.size()) - 6;
  if (freedom < 3) return;
  const Eigen::Vector3d about = hypotheses_.front().T.translation();
  const Vector6d twist = fit_twist(frame, about).twist;
  double sum = 0;
  for (std::size_t k = 0; k < frame.contacts.size(); ++k) {
    const Eigen::Vector3d there =
        twist.tail<3>() + twist.head<3>().cross(frame.contacts[k].p - about);
    sum += (frame.velocities[k] - there).squaredNorm();
  }
  const double share = std::min(1.0, dt / kLearningTime);
  const double least = 0.25 * std::pow(options_.velocity_noise, 2);
  velocity_variance_ =
      std::max(least, velocity_variance_ + share * (sum / freedom - velocity_variance_));
}

/// Minimises |x|^2 / 2 in the prior's metric plus trust times the contacts' energy, from `start`;
/// the weight takes Laplace's approximation of the integral.
void Tracker::correct(const Evidence& evidence, double trust, const Eigen::Isometry3d& start,
                      Hypothesis& hypothesis) const {
  const ContactTerm contacts(model_, evidence, kContactOffset, 1.0);
  const Matrix6d information = hypothesis.covariance.inverse();
  const Eigen::Isometry3d predicted = hypothesis.T;
  const auto cost = [&](const Eigen::Isometry3d& T) {
    const Vector6d x = difference(T, predicted);
    return 0.5 * x.dot(information * x) +
           trust * static_cast<double>(contacts.energy(search_pose(T), kNoBound));
  };
  hypothesis.move_to(start);
  double now = cost(start);
  Matrix6d H = information;
  for (int i = 0; i <= kIterations; ++i) {
    NormalEquations equations;
    contacts.linearize(search_pose(hypothesis.T), equations);
    H = information + trust * equations.H;
    if (i == kIterations) break;
    const Vector6d x = difference(hypothesis.T, predicted);
    const Vector6d step = -H.llt().solve(information * x + trust * equations.g);
    const double before = now;
    for (const double share : kShortened) {
      const Eigen::Isometry3d to = moved(hypothesis.T, share * step);
      const double there = cost(to);
      if (there >= now) continue;
      hypothesis.move_to(to);
      now = there;
      break;
    }
    if (now >= before) break;
  }
  hypothesis.log_weight -= now + 0.5 * (log_determinant(H) - log_determinant(information));
  hypothesis.covariance = H.inverse();
}

void Tracker::watch_for_slip(const Evidence& evidence) {
  const ContactTerm contacts(model_, evidence, kContactOffset, 1.0);
  const double energy =
      static_cast<double>(contacts.energy(search_pose(hypotheses_.front().T), kNoBound));
  energies_.push_back(energy / static_cast<double>(evidence.contacts.size()));
  if (energies_.size() > kBefore + kRecent) energies_.erase(energies_.begin());
  if (searching() || energies_.size() < kSettling + kRecent) return;
  const std::size_t split = energies_.size() - kRecent;
  const double jump = mean_of(energies_, split, energies_.size()) - mean_of(energies_, 0, split);
  if (jump < options_.slip_jump) return;
  ++slips_;
  energies_.clear();
  searched_ = 0;
  const auto slipped = recent_.end() - kSlipped;
  const auto first = slipped - std::min<std::ptrdiff_t>(slipped - recent_.begin(), kLearnt + 1);
  const KnownErrors before = mean_errors({first, slipped - 1}, model_, hypotheses_.front().T);
  errors_before_ = before.mean;
  learnt_frames_ = before.frames;
  recent_.erase(recent_.begin(), slipped);
  before_slip_ = hypotheses_;
  for (Hypothesis& hypothesis : before_slip_) {
    hypothesis.covariance.diagonal().head<3>().array() += std::pow(options_.slip_angle, 2) / 3;
    hypothesis.covariance.diagonal().tail<3>().array() += std::pow(options_.slip_distance, 2) / 3;
  }
}

/// Keeps the contacts of a frame, and moves those before along with the object.
void Tracker::remember(const TrackFrame& frame, const Eigen::Isometry3d& motion) {
  for (auto& contacts : recent_) {
    for (auto& contact : contacts) {
      contact.p = motion * contact.p;
      contact.n = motion.linear() * contact.n;
    }
  }
  for (auto& error : errors_before_) {
    error.p = motion.linear() * error.p;
    error.n = motion.linear() * error.n;
  }
  if (frame.contacts.empty()) return;
  recent_.push_back(frame.contacts);
  for (auto& contact : recent_.back()) contact.time = frame.time;
  if (recent_.size() > kMaxFrames) recent_.erase(recent_.begin());
}

/// All hypotheses again: those before the slip, corrected by the mean of the contacts since, from
/// where they are, from poses about them, and from what the last frame has found.
void Tracker::search_slip(const Evidence& evidence, double dt) {
  const double watched = recent_.back().front().time - recent_.front().front().time;
  const LastingErrors errors{options_.correlated_share, options_.correlation_time,
                             watched / static_cast<double>(recent_.size() - 1)};
  Evidence since = evidence;
  since.contacts = mean_contacts(recent_, errors, {errors_before_, learnt_frames_});
  std::vector<Hypothesis> found;
  const auto from = [&](const Hypothesis& before, const Eigen::Isometry3d& start) {
    Hypothesis hypothesis = before;
    correct(since, 1.0, start, hypothesis);
    found.push_back(hypothesis);
  };
  for (const Hypothesis& before : before_slip_) from(before, before.T);
  const Hypothesis& likeliest = before_slip_.front();
  for (const Hypothesis& last : hypotheses_) from(likeliest, last.T);
  for (int i = 0; i < options_.slip_poses; ++i) {
    Vector6d x;
    x << options_.slip_angle / std::sqrt(3.0) * random_.normal3(),
        options_.slip_distance / std::sqrt(3.0) * random_.normal3();
    from(likeliest, moved(likeliest.T, x));
  }
  hypotheses_ = std::move(found);
  searched_ += dt;
  if (searched_ > options_.slip_search) before_slip_.clear();
}

void Tracker::prune() {
  const auto heavier = [](const Hypothesis& a, const Hypothesis& b) {
    return a.log_weight > b.log_weight;
  };
  std::stable_sort(hypotheses_.begin(), hypotheses_.end(), heavier);
  const double most = hypotheses_.front().log_weight;
  const SymmetryGroup symmetries(model_.object().symmetries);
  std::vector<Hypothesis> kept;
  for (Hypothesis& hypothesis : hypotheses_) {
    hypothesis.log_weight -= most;
    if (hypothesis.log_weight < -kLoss || kept.size() == kMaxHypotheses) break;
    const PoseFamily ball{PosePoint(hypothesis.T)};
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Hypothesis& other) {
      return ball.contains(PosePoint(other.T), symmetries, kSamePose);
    });
    if (!known) kept.push_back(hypothesis);
  }
  hypotheses_ = std::move(kept);
}

void Tracker::publish() {
  posterior_.modes.clear();
  double total = 0;
  for (const Hypothesis& h : hypotheses_) total += std::exp(h.log_weight);
  for (const Hypothesis& h : hypotheses_) {
    const double weight = std::exp(h.log_weight) / total * probability_near(h.covariance);
    posterior_.modes.push_back({h.T, weight, h.covariance, h.free_axis});
  }
  std::stable_sort(posterior_.modes.begin(), posterior_.modes.end(),
                   [](const Mode& a, const Mode& b) { return a.weight > b.weight; });
  posterior_.status = status_of(posterior_.modes);
}

const Posterior& Tracker::update(const TrackFrame& frame) {
  const auto start = std::chrono::steady_clock::now();
  check_frame(frame);
  Evidence evidence;
  evidence.contacts = frame.contacts;
  evidence.false_contact_share = options_.false_contacts;
  evidence.noise_scale_prior = evidence.size_prior = 0;  // a slip would pass for noise
  check_evidence(model_, evidence);
  if (started_ && frame.time <= time_) return posterior_;
  const double gap = started_ ? frame.time - time_ : 0.0, dt = std::min(gap, kLongestGap);
  started_ = true;
  time_ = frame.time;
  if (dt > 0) learn_sliding(frame, dt);
  const Eigen::Isometry3d before = hypotheses_.front().T;
  for (Hypothesis& hypothesis : hypotheses_) predict(frame, dt, gap, hypothesis);
  for (Hypothesis& hypothesis : before_slip_) predict(frame, dt, gap, hypothesis);
  remember(frame, hypotheses_.front().T * before.inverse());
  if (!frame.contacts.empty()) {
    watch_for_slip(evidence);
    if (searching()) {
      search_slip(evidence, dt);
    } else {
      const double time = 2 * options_.correlation_time * options_.correlated_share;
      const double trust = std::min(1.0, std::max(dt, 1e-3) / time);
      for (Hypothesis& hypothesis : hypotheses_) {
        correct(evidence, trust, hypothesis.T, hypothesis);
      }
    }
    prune();
  }
  publish();
  posterior_.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return posterior_;
}

}  // namespace palpate::localization
