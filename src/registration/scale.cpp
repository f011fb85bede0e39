// SPDX-License-Identifier: Apache-2.0
#include "registration/scale.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "palpate/core/random.hpp"
#include "registration/clock.hpp"
#include "registration/final_solve.hpp"

namespace palpate::registration {
namespace {

constexpr double kBin = 0.02;   // of the logarithm of a ratio
constexpr int kBins = 1200;     // ratios of e^-12 to e^12
constexpr int kCandidates = 5;  // scales tried

/// Logarithm of target length over source length of a pair of pairs.
struct Vote {
  double log_ratio, target_length;
};

/// Of random pairs of pairs. Lengths below a few noise bounds have no information.
std::vector<Vote> votes_of(const Correspondences& c, double noise_bound, RandomStream random) {
  constexpr int kVotes = 200000;
  constexpr double kMinLength = 5;
  std::vector<Vote> votes;
  for (int k = 0; k < kVotes; ++k) {
    const std::size_t i = random.index(c.size()), j = random.index(c.size());
    const double s = (c.source[i] - c.source[j]).norm(), t = (c.target[i] - c.target[j]).norm();
    if (s > 0 && !(t < kMinLength * noise_bound)) votes.push_back({std::log(t / s), t});
  }
  return votes;
}

double position(double log_ratio) { return log_ratio / kBin + kBins / 2.0; }

std::vector<double> counts_of(const std::vector<Vote>& votes) {
  std::vector<double> counts(kBins, 0);
  for (const Vote& vote : votes) {
    const double at = position(vote.log_ratio);
    if (at >= 0 && at < kBins) ++counts[static_cast<std::size_t>(at)];
  }
  return counts;
}

/// The bins that stand out most from their surroundings.
std::vector<int> peaks_of(const std::vector<double>& counts) {
  constexpr int kAround = 10;
  std::vector<std::pair<double, int>> peaks;
  for (int bin = kAround; bin < kBins - kAround; ++bin) {
    double around = 0;
    for (int k = -kAround; k <= kAround; ++k) around += counts[static_cast<std::size_t>(bin + k)];
    const double here = counts[static_cast<std::size_t>(bin)], mean = around / (2 * kAround + 1);
    if (here > 0) peaks.emplace_back((here - mean) / std::sqrt(mean + 1), bin);
  }
  std::ranges::sort(peaks, std::greater<>());
  std::vector<int> bins;
  for (const auto& [height, bin] : peaks) {
    if (static_cast<int>(bins.size()) == kCandidates) break;
    bins.push_back(bin);
  }
  return bins;
}

/// Middle of the votes where they are densest, to within a width (half-sample mode, Bickel &
/// Fruehwirth 2006).
double densest(std::vector<double> sorted, double width) {
  constexpr std::size_t kFewest = 8;
  auto first = sorted.begin(), last = sorted.end() - 1;
  while (*last - *first > width && last - first >= static_cast<std::ptrdiff_t>(kFewest)) {
    const auto half = (last - first) / 2;
    auto best = first;
    for (auto low = first; low + half <= last; ++low) {
      if (*(low + half) - *low < *(best + half) - *best) best = low;
    }
    first = best;
    last = best + half;
  }
  return (*first + *last) / 2;
}

/// The scale of a bin: its middle, or closer where a bin moves points by many noise bounds.
double scale_of(int bin, const std::vector<Vote>& votes, double noise_bound) {
  constexpr std::size_t kEnough = 20000;
  constexpr double kAgrees = 0.5, kCoarse = 0.25;  // noise bounds; bins
  std::vector<double> ratios, lengths;
  for (const Vote& vote : votes) {
    if (std::abs(position(vote.log_ratio) - bin - 0.5) > 1) continue;
    ratios.push_back(vote.log_ratio);
    lengths.push_back(vote.target_length);
    if (ratios.size() == kEnough) break;
  }
  const double middle = (bin + 0.5 - kBins / 2.0) * kBin;
  if (ratios.empty()) return std::exp(middle);
  const auto median = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::ranges::nth_element(lengths, median);
  const double width = kAgrees * noise_bound / *median;
  if (width > kCoarse * kBin) return std::exp(middle);
  std::ranges::sort(ratios);
  return std::exp(densest(std::move(ratios), width));
}

std::vector<double> candidates(const std::vector<Vote>& votes, double noise_bound) {
  std::vector<double> scales;
  for (const int bin : peaks_of(counts_of(votes))) {
    scales.push_back(scale_of(bin, votes, noise_bound));
  }
  return scales;
}

Correspondences scaled(Correspondences c, double scale) {
  for (auto& p : c.source) p *= scale;
  return c;
}

struct Similarity {
  double scale = 0;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();  // of the scaled source
};

/// Scale that minimises the squared residuals of the inliers for their rotation, and the pose with
/// it: of far coordinates a little more scale moves the points by much.
Similarity fitted(const Correspondences& c, const RegistrationResult& result) {
  const Origins means = weighted_means(c, result.weights);
  const Eigen::Matrix3d R = result.T_target_source->linear();
  double product = 0, squares = 0;
  for (const int i : result.inliers) {
    const auto index = static_cast<std::size_t>(i);
    const double w = result.weights[index];
    const Eigen::Vector3d s = c.source[index] - means.source;
    product += w * (c.target[index] - means.target).dot(R * s);
    squares += w * s.squaredNorm();
  }
  Similarity fit{squares > 0 ? product / squares : 0, *result.T_target_source};
  fit.T.translation() = means.target - R * (fit.scale * means.source);
  return fit;
}

/// The registration at a scale, scale and pose in turn.
std::optional<RegistrationResult> registered_at(double scale, const Correspondences& c,
                                                RegistrationOptions options) {
  constexpr int kRounds = 4;
  options.estimate_scale = false;
  options.instances = 1;
  options.robust_bound.max_nodes = 0;
  std::optional<RegistrationResult> result;
  for (int round = 0; round < kRounds; ++round) {
    RegistrationResult next = register_correspondences(scaled(c, scale), options);
    if (result && next.inliers.size() < result->inliers.size()) break;
    next.scale = scale;
    result = std::move(next);
    if (!result->T_target_source) break;
    const Similarity fit = fitted(c, *result);
    options.initial = fit.T;
    scale = fit.scale;
    if (!(scale > 0)) break;
  }
  return result;
}

/// What is asked for once the scale is known: further poses, and what no pose can exceed.
void complete(const Correspondences& correspondences, RegistrationOptions options,
              RegistrationResult& result) {
  if (!result.T_target_source) return;
  options.estimate_scale = false;
  options.initial.reset();
  const Correspondences at_scale = scaled(correspondences, result.scale);
  if (options.instances > 1) find_more(at_scale, options, result);
  bound_robustly(at_scale, options, result);
}

/// At a small scale many pairs agree, by chance: evidence counts before their number.
bool is_better(const RegistrationResult& a, const RegistrationResult& b) {
  const bool has_a = a.T_target_source.has_value(), has_b = b.T_target_source.has_value();
  if (has_a != has_b) return has_a;
  if (a.false_alarms != b.false_alarms) return a.false_alarms < b.false_alarms;
  return a.inliers.size() > b.inliers.size();
}

}  // namespace

RegistrationResult register_scaled(const Correspondences& correspondences,
                                   const RegistrationOptions& options) {
  const double start = now();
  RegistrationOptions rigid = options;
  // Each scale that is tried is another chance of a false alarm.
  rigid.max_false_alarms = options.max_false_alarms / kCandidates;
  RegistrationResult best;
  best.weights.assign(correspondences.size(), 0);
  best.status = RegistrationStatus::kDegenerate;
  best.false_alarms = 1;
  if (correspondences.size() < 4) return best;
  best.status = RegistrationStatus::kNoConsensus;
  best.false_alarms = 1.0 / kCandidates;
  const double noise_bound = options.noise_bound;
  const RandomStream random(options.seed, "scale");
  const auto votes = votes_of(correspondences, noise_bound, random);
  for (const double scale : candidates(votes, noise_bound)) {
    auto result = registered_at(scale, correspondences, rigid);
    if (result && is_better(*result, best)) best = std::move(*result);
  }
  best.false_alarms *= kCandidates;
  complete(correspondences, options, best);
  best.seconds = now() - start;
  return best;
}

}  // namespace palpate::registration
