// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/information/next_touch.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "localization/search/pose_family.hpp"
#include "palpate/core/error.hpp"

namespace palpate::localization {
namespace {

constexpr double kTouching = 0.0002;  // m at which the ball counts as touching
constexpr int kMaxSteps = 80;
constexpr double kForgotten = 12;  // exponent beyond which two outcomes are nothing alike
constexpr double kUnitTolerance = 1e-3;

/// Square root of a covariance; tiny negative eigenvalues of rounding count as 0.
Matrix6d root_of(const Matrix6d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> spectrum(covariance);
  const Vector6d sigmas = spectrum.eigenvalues().cwiseMax(0).cwiseSqrt();
  return spectrum.eigenvectors() * sigmas.asDiagonal();
}

Eigen::Isometry3d drawn_from(const Mode& mode, const Matrix6d& root, RandomStream& random) {
  Vector6d x;
  x << random.normal3(), random.normal3();
  x = root * x;
  Eigen::Isometry3d T = mode.T_frame_object;
  T.linear() = exp_so3(x.head<3>()) * T.linear();
  T.translation() += x.tail<3>();
  if (!mode.free_axis) return T;
  const PoseFamily family(PosePoint(T), *mode.free_axis);
  return family.at(random.uniform(-1, 1) * mode.free_axis->extent).isometry();
}

std::vector<PredictedTouch> outcomes_of(const geometry::ObjectModel& model,
                                        const std::vector<Eigen::Isometry3d>& poses,
                                        std::size_t count, const TouchAction& probe,
                                        double tip_radius) {
  std::vector<PredictedTouch> outcomes;
  for (std::size_t i = 0; i < std::min(count, poses.size()); ++i) {
    outcomes.push_back(predict_touch(model, poses[i], probe, tip_radius));
  }
  return outcomes;
}

/// Exponent of the bound for two outcomes; infinite for a hit and a miss.
double unlikeness(const PredictedTouch& a, const PredictedTouch& b,
                  const NextTouchOptions& options) {
  if (a.hit != b.hit) return std::numeric_limits<double>::infinity();
  if (!a.hit) return 0;
  const double along = (a.distance - b.distance) / options.point_sigma;
  const double exponent = along * along / 8;
  if (exponent >= kForgotten) return exponent;
  return exponent +
         (a.normal - b.normal).squaredNorm() / (8 * options.normal_sigma * options.normal_sigma);
}

/// -sum_i w_i ln sum_j w_j exp(-exponent(i, j)), w the weights over their sum.
template <class Exponent>
double bound_of(const std::vector<double>& weights, const Exponent& exponent) {
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<double> alike = weights;  // to itself
  for (std::size_t i = 0; i < weights.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double unlike = exponent(i, j);
      if (unlike >= kForgotten) continue;
      const double likeness = std::exp(-unlike);
      alike[i] += weights[j] * likeness;
      alike[j] += weights[i] * likeness;
    }
  }
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] > 0) sum -= weights[i] / total * std::log(alike[i] / total);
  }
  return sum;
}

void check(const Posterior& posterior, const std::vector<TouchAction>& probes) {
  if (probes.empty()) throw BadInput("next touch: 0 probes to choose from");
  if (posterior.modes.empty()) throw BadInput("next touch: a posterior of 0 modes");
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const TouchAction& probe = probes[i];
    const bool fine = probe.start.allFinite() && std::isfinite(probe.reach) &&
                      std::abs(probe.direction.norm() - 1) < kUnitTolerance && probe.seconds > 0;
    if (fine) continue;
    throw BadInput(fmt::format("next touch: probe {} has length {} of direction, {} s, {} m reach",
                               i, probe.direction.norm(), probe.seconds, probe.reach));
  }
}

void check(const std::vector<PredictedTouches>& outcomes, const std::vector<double>& weights) {
  if (outcomes.size() != weights.size()) {
    throw BadInput(
        fmt::format("next touch: {} weights of {} outcomes", weights.size(), outcomes.size()));
  }
  double sum = 0;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    if (outcomes[i].size() != outcomes[0].size()) {
      throw BadInput(fmt::format("next touch: outcome {} is {} touches, the first {}", i,
                                 outcomes[i].size(), outcomes[0].size()));
    }
    if (!(weights[i] >= 0)) throw BadInput(fmt::format("next touch: weight {}", weights[i]));
    sum += weights[i];
  }
  if (!outcomes.empty() && !(sum > 0 && std::isfinite(sum))) {
    throw BadInput(fmt::format("next touch: the weights' sum is {}", sum));
  }
}

}  // namespace

PredictedTouch predict_touch(const geometry::ObjectModel& model,
                             const Eigen::Isometry3d& T_frame_object, const TouchAction& probe,
                             double tip_radius) {
  const Eigen::Isometry3d T_object_frame = T_frame_object.inverse();
  const Eigen::Vector3f start = (T_object_frame * probe.start).cast<float>();
  const Eigen::Vector3f direction = (T_object_frame.linear() * probe.direction).cast<float>();
  const Eigen::AlignedBox3f box = model.bounds();
  PredictedTouch touch;
  for (int step = 0; step < kMaxSteps && touch.distance <= probe.reach; ++step) {
    const Eigen::Vector3f at = start + static_cast<float>(touch.distance) * direction;
    const float beside = box.exteriorDistance(at);
    const double distance =
        static_cast<double>(beside < model.field().beyond() ? model.field().distance(at) : beside);
    if (distance - tip_radius > kTouching) {
      touch.distance += distance - tip_radius;
      continue;
    }
    const auto sample = model.field().at(at);
    if (!sample) return touch;
    touch.hit = true;
    touch.normal = T_frame_object.linear() * sample->gradient.cast<double>().normalized();
    return touch;
  }
  return touch;
}

double information_bound(const std::vector<PredictedTouch>& outcomes,
                         const NextTouchOptions& options) {
  const std::vector<double> weights(outcomes.size(), 1.0);
  return bound_of(weights, [&](std::size_t i, std::size_t j) {
    return unlikeness(outcomes[i], outcomes[j], options);
  });
}

double information_bound(const std::vector<PredictedTouches>& outcomes,
                         const std::vector<double>& weights, const NextTouchOptions& options) {
  check(outcomes, weights);
  return bound_of(weights, [&](std::size_t i, std::size_t j) {
    double exponent = 0;
    for (std::size_t k = 0; k < outcomes[i].size() && exponent < kForgotten; ++k) {
      exponent += unlikeness(outcomes[i][k], outcomes[j][k], options);
    }
    return exponent;
  });
}

std::vector<Eigen::Isometry3d> draw_poses(const Posterior& posterior, int count,
                                          RandomStream& random) {
  double total = 0;
  for (const Mode& mode : posterior.modes) total += mode.weight;
  std::vector<Eigen::Isometry3d> poses;
  std::size_t m = 0;
  double reached = posterior.modes.front().weight;
  Matrix6d root = root_of(posterior.modes.front().covariance);
  const double start = random.uniform();
  for (int i = 0; i < count; ++i) {  // systematic: every mode gets its share
    const double mark = (start + i) / count * total;
    while (mark > reached && m + 1 < posterior.modes.size()) {
      reached += posterior.modes[++m].weight;
      root = root_of(posterior.modes[m].covariance);
    }
    poses.push_back(drawn_from(posterior.modes[m], root, random));
  }
  for (std::size_t i = poses.size(); i > 1; --i) std::swap(poses[i - 1], poses[random.index(i)]);
  return poses;
}

TouchChoice choose_touch(const geometry::ObjectModel& model, const Posterior& posterior,
                         const std::vector<TouchAction>& probes, RandomStream random,
                         const NextTouchOptions& options) {
  check(posterior, probes);
  const auto poses = draw_poses(posterior, options.poses, random);
  const auto bound = [&](std::size_t i, int count) {
    return information_bound(
        outcomes_of(model, poses, static_cast<std::size_t>(count), probes[i], options.tip_radius),
        options);
  };
  using Scored = std::pair<double, std::size_t>;  // information a second, probe
  std::vector<Scored> scored;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    scored.emplace_back(bound(i, options.few_poses) / probes[i].seconds, i);
  }
  std::stable_sort(scored.begin(), scored.end(),
                   [](const Scored& a, const Scored& b) { return a.first > b.first; });
  scored.resize(std::min(scored.size(), static_cast<std::size_t>(options.finalists)));
  TouchChoice best;
  double best_rate = -1;
  for (const auto& [rough, i] : scored) {
    const double information = bound(i, options.poses);
    if (information / probes[i].seconds <= best_rate) continue;
    best_rate = information / probes[i].seconds;
    best = {i, information};
  }
  return best;
}

}  // namespace palpate::localization
