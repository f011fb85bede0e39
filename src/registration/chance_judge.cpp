// SPDX-License-Identifier: Apache-2.0
#include "registration/chance_judge.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace palpate::registration {
namespace {

Eigen::Matrix3d second_moment(const Eigen::ArrayXf (&axes)[3]) {
  Eigen::Matrix3d moment;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b <= a; ++b) {
      moment(a, b) = moment(b, a) = static_cast<double>((axes[a] * axes[b]).mean());
    }
  }
  return moment;
}

/// Information of a turn: sum of the squared distances to its axis.
Eigen::Matrix3d inertia(const Eigen::Matrix3d& moment) {
  return moment.trace() * Eigen::Matrix3d::Identity() - moment;
}

}  // namespace

ChanceJudge::ChanceJudge(const Scorer& scorer, double false_alarm, const RandomStream& random)
    : scorer_(scorer),
      false_alarm_(false_alarm),
      random_(random),
      spread_(second_moment(scorer.columns().s)) {
  model_.dimensions = scorer.dimensions();
  model_.pairs = scorer.size();
  model_.inertia = inertia(spread_);
  const double chord = scorer.chord_bound();
  if (chord > 0) {
    model_.normal_information = inertia(second_moment(scorer.columns().n)) / (chord * chord);
    model_.orientations = 2 * std::numbers::pi * chord * chord;
  }
}

double ChanceJudge::quick(const Eigen::Isometry3d& T) const {
  constexpr int kShifts = 4;
  const int others = scorer_.size() - 1, shifts = std::min(kShifts, others);
  RandomStream random = random_.fork("shift");
  double hits = 1;
  for (int k = 0; k < shifts; ++k) {
    const auto shift = 1 + static_cast<int>(random.index(static_cast<std::size_t>(others)));
    hits += scorer_.count_shifted(T, shift);
  }
  ChanceModel all_alike = model_;
  all_alike.rate = hits / std::max(1, shifts);
  const Score score = scorer_.score_of_distinct(T);
  return expected_by_chance(all_alike, score.count - score.gain, score.count);
}

double ChanceJudge::exact(const Eigen::Isometry3d& T) {
  const double bound = quick(T);
  if (bound < kClearAtOnce) return bound;
  // With normals fewer places gather anything.
  const Effort most{.poses = scorer_.dimensions() > 3 ? 1024 : 512, .sources = 512};
  // A few poses may miss places that gather much, and so make chance look too rare.
  constexpr std::pair<Effort, double> kEnoughBelow[] = {{kRough, 1e-6}, {kMedium, 1e-3}};
  constexpr double kFarAbove = 100;
  for (const auto& [effort, share] : kEnoughBelow) {
    const double expected = judge(T, effort);
    if (expected < share * false_alarm_ || expected > kFarAbove * false_alarm_) return expected;
  }
  return judge(T, most);
}

double ChanceJudge::judge(const Eigen::Isometry3d& T, Effort effort) {
  constexpr int kMostPoses = 4096;
  const Score score = scorer_.score_of_distinct(T);
  if (score.count <= 3) return expected_by_chance(model_, 0, score.count);
  // Of few pairs, all and at more poses.
  const int sources = std::min(effort.sources, scorer_.size() - 1);
  const int poses = std::min(kMostPoses, effort.poses * effort.sources / sources);
  const double squares = score.count - score.gain;
  const double radius = matching_radius(model_.dimensions, squares, score.count);
  Rates& rates = rates_within(radius, sources);
  extend(rates, poses);
  ChanceModel chance = model_;
  chance.radius = rates.radius;
  chance.rate = power_mean(rates, T, score.count - 1);
  return expected_by_chance(chance, squares, score.count);
}

ChanceJudge::Rates& ChanceJudge::rates_within(double radius, int sources) {
  constexpr double kStep = 1.25;
  const int step = static_cast<int>(std::lround(std::log(radius) / std::log(kStep)));
  const std::pair key{step, sources};
  if (const auto known = rates_.find(key); known != rates_.end()) return known->second;
  const double rounded = std::pow(kStep, step);
  Rates rates{rounded,
              sources,
              {scorer_.columns(), scorer_.chord_bound(), rounded},
              random_.fork("poses", static_cast<std::uint64_t>(-step))};
  return rates_.emplace(key, std::move(rates)).first->second;
}

void ChanceJudge::extend(Rates& rates, int poses) const {
  const int step = scorer_.size() / rates.sources;
  while (static_cast<int>(rates.poses.size()) < poses) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    const int source = rates.pairings.propose(rates.random, T);
    rates.poses.push_back(T);
    rates.pairings.agreements(T, {source + 1, step, rates.sources}, rates.counts.emplace_back());
  }
}

/// The power mean of the rates at the poses that are not the same as T, and one standard error
/// more; where too few sources agree for that, the mean.
double ChanceJudge::power_mean(const Rates& rates, const Eigen::Isometry3d& T, int power) const {
  double sum = 1, powers = 0, squares = 0;
  for (std::size_t i = 0; i < rates.poses.size(); ++i) {
    if (same(T, rates.poses[i])) continue;
    const auto& counts = rates.counts[i];
    const double estimate = power_of_mean(counts, rates.sources, power);
    sum += std::accumulate(counts.begin(), counts.end(), 0.0);
    powers += estimate;
    squares += estimate * estimate;
  }
  const auto poses = static_cast<double>(rates.poses.size());
  const double mean_power = (powers + std::sqrt(squares)) / poses;
  const double mean = sum / (poses * rates.sources);
  return std::max(mean, std::pow(mean_power, 1.0 / power)) / rates.pairings.coarseness();
}

/// Whether two poses are the same answer: they move the sources alike to within three bounds, root
/// mean square. What agrees at both speaks for the same pose, not for another one by chance.
bool ChanceJudge::same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const {
  constexpr double kBounds = 3;
  const Eigen::Matrix3d turn = a.linear() - b.linear();
  // The sources' mean is the origin.
  const double squares = (turn * spread_ * turn.transpose()).trace() +
                         (a.translation() - b.translation()).squaredNorm();
  return squares < kBounds * kBounds;
}

}  // namespace palpate::registration
