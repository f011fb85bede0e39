// SPDX-License-Identifier: Apache-2.0
#include "chance_judge.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::registration {
namespace {

constexpr int kSources = 128;  // looked up at a pose
constexpr int kRoughPoses = 64, kExactPoses = 512, kExactPosesWithNormals = 1024;

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
  all_alike.hits = {hits};
  all_alike.trials = std::max(1, shifts);
  const Score score = scorer_.score_of_distinct(T);
  return expected_by_chance(all_alike, score.count - score.gain, score.count);
}

double ChanceJudge::rough(const Eigen::Isometry3d& T) { return judge(T, kRoughPoses); }

double ChanceJudge::exact(const Eigen::Isometry3d& T) {
  // A few poses may miss places that gather much, and so make chance look too rare.
  constexpr double kFarBelow = 1e-6, kFarAbove = 100;
  const double first = rough(T);
  if (first < false_alarm_ * kFarBelow || first > false_alarm_ * kFarAbove) return first;
  return judge(T, scorer_.dimensions() > 3 ? kExactPosesWithNormals : kExactPoses);
}

double ChanceJudge::judge(const Eigen::Isometry3d& T, int poses) {
  const Score score = scorer_.score_of_distinct(T);
  if (score.count <= 3) return expected_by_chance(model_, 0, score.count);
  const double squares = score.count - score.gain;
  Rates& rates = rates_within(matching_radius(model_.dimensions, squares, score.count));
  // Fewer sources, more poses.
  const int sources = std::min(kSources, scorer_.size() - 1);
  extend(rates, poses * std::min(8, kSources / sources));
  ChanceModel chance = model_;
  chance.radius = rates.radius;
  chance.trials = sources * rates.pairings.coarseness();
  chance.hits = rates.hits;
  for (std::size_t i = 0; i < rates.poses.size(); ++i) {
    if (same(T, rates.poses[i])) chance.hits[i] = 0;
  }
  return expected_by_chance(chance, squares, score.count);
}

ChanceJudge::Rates& ChanceJudge::rates_within(double radius) {
  constexpr double kStep = 1.25;
  const int step = static_cast<int>(std::lround(std::log(radius) / std::log(kStep)));
  if (const auto known = rates_.find(step); known != rates_.end()) return known->second;
  const double rounded = std::pow(kStep, step);
  Rates rates{rounded,
              {scorer_.columns(), scorer_.chord_bound(), rounded},
              random_.fork("poses", static_cast<std::uint64_t>(-step))};
  return rates_.emplace(step, std::move(rates)).first->second;
}

void ChanceJudge::extend(Rates& rates, int poses) const {
  const int sources = std::min(kSources, scorer_.size() - 1), step = scorer_.size() / sources;
  while (static_cast<int>(rates.poses.size()) < poses) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    const int source = rates.pairings.propose(rates.random, T);
    rates.poses.push_back(T);
    rates.hits.push_back(rates.pairings.hits(T, source + 1, step, sources));
  }
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
