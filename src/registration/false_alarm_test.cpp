// SPDX-License-Identifier: Apache-2.0
#include "registration/false_alarm_test.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace palpate::registration {
namespace {

Eigen::Matrix3d second_moment(const Eigen::ArrayXf (&axes)[3], int count) {
  Eigen::Matrix3d moment;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b <= a; ++b) {
      const float mean = (axes[a].head(count) * axes[b].head(count)).mean();
      moment(a, b) = moment(b, a) = static_cast<double>(mean);
    }
  }
  return moment;
}

/// Different ones of so many.
std::array<int, 4> four_of(int count, RandomStream& random) {
  std::array<int, 4> chosen{};
  for (std::size_t k = 0; k < chosen.size();) {
    chosen[k] = static_cast<int>(random.index(static_cast<std::size_t>(count)));
    const auto end = chosen.begin() + static_cast<std::ptrdiff_t>(k);
    if (std::find(chosen.begin(), end, chosen[k]) == end) ++k;
  }
  return chosen;
}

/// Information of a turn: sum of the squared distances to its axis.
Eigen::Matrix3d inertia(const Eigen::Matrix3d& moment) {
  return moment.trace() * Eigen::Matrix3d::Identity() - moment;
}

}  // namespace

FalseAlarmTest::FalseAlarmTest(const Scorer& scorer, double max_false_alarms,
                               const Dependence& dependence, const RandomStream& random)
    : scorer_(scorer),
      max_false_alarms_(max_false_alarms),
      dependence_(dependence),
      random_(random),
      spread_(second_moment(scorer.columns().s, scorer.size())) {
  model_.dimensions = scorer.dimensions();
  model_.pairs = scorer.size();
  model_.inertia = inertia(spread_);
  const double chord = scorer.chord_bound();
  if (chord > 0) {
    const Eigen::Matrix3d normals = second_moment(scorer.columns().n, scorer.size());
    model_.normal_information = inertia(normals) / (chord * chord);
    model_.orientations = 2 * std::numbers::pi * chord * chord;
  }
}

/// Share of further pairs that lie near one of the pairs T does not explain, in both frames, beyond
/// what pairing the same points at random would put there; plus the pair itself.
double FalseAlarmTest::copies_among_others(const Eigen::Isometry3d& T) const {
  constexpr int kPairs = 48, kOthers = 256, kLeast = 3;
  constexpr double kRare = 0.1, kDeviations = 2;
  const int size = scorer_.size();
  const PairColumns& columns = scorer_.columns();
  const auto radius = static_cast<float>(dependence_.copies), squared = radius * radius;
  const std::vector<int> inliers = scorer_.near(T, 1);
  RandomStream random = random_.fork("copies");
  const int others = std::min(size, kOthers);
  int found = 0, by_chance = 0, looked = 0;
  for (int k = 0; k < 2 * kPairs && looked < kPairs; ++k) {
    const auto i = static_cast<int>(random.index(static_cast<std::size_t>(size)));
    if (std::ranges::binary_search(inliers, i)) continue;
    ++looked;
    const auto first = random.index(static_cast<std::size_t>(size));
    for (int q = 0; q < others; ++q) {
      int j = static_cast<int>(first) + q * size / others;
      if (j >= size) j -= size;
      if (j == i || std::abs(columns.s[0][i] - columns.s[0][j]) > radius) continue;
      found += are_near(columns, i, j, squared);
      by_chance += are_near(columns, i, j, squared, (j + 1 + size / 3) % size);
    }
  }
  const double excess =
      static_cast<double>(found - by_chance) * size / others / std::max(1, looked);
  // Where many lie near one another by chance, their number varies by chance.
  const double deviation = std::sqrt(static_cast<double>(found + by_chance));
  const bool more = found - by_chance >= std::max<double>(kLeast, kDeviations * deviation);
  return more && excess > kRare ? 1 + excess : 1;
}

double FalseAlarmTest::copies(const Eigen::Isometry3d& T) {
  if (!copies_) copies_ = copies_among_others(T);
  return *copies_;
}

FalseAlarmTest::Evidence FalseAlarmTest::evidence(const Eigen::Isometry3d& T) {
  const double each = copies(T);
  if (each == 1) return {scorer_.score_of_distinct(T)};
  return {scorer_.score_of_separate(T, static_cast<float>(dependence_.reach)), each};
}

/// Copies make neither more pairs nor more agreement.
double FalseAlarmTest::expected(BackgroundModel background, const Score& score,
                                double copies) const {
  background.pairs /= copies;
  background.rate /= copies;
  return number_of_false_alarms(background, score.count - score.gain, score.count);
}

/// As if pairs agreed at all poses as often as those of the same points, paired otherwise, do here.
BackgroundModel FalseAlarmTest::all_alike(const Eigen::Isometry3d& T) const {
  constexpr int kShifts = 4;
  const int others = scorer_.size() - 1, shifts = std::min(kShifts, others);
  RandomStream random = random_.fork("shift");
  double hits = 1;
  for (int k = 0; k < shifts; ++k) {
    const auto shift = 1 + static_cast<int>(random.index(static_cast<std::size_t>(others)));
    hits += scorer_.count_shifted(T, shift);
  }
  BackgroundModel model = model_;
  model.rate = hits / std::max(1, shifts);
  return model;
}

double FalseAlarmTest::quick(const Eigen::Isometry3d& T) {
  const BackgroundModel background = all_alike(T);
  const auto number = [&](const Score& score, double copies) {
    BackgroundModel all_alike = background;
    const double uniform = expected(all_alike, score, copies);
    if (!(uniform < kClearAtOnce)) return uniform;
    const double by_count = expected_on_grid(all_alike, score, copies);
    if (!(by_count < kClearAtOnce) && is_on_grid(radius_of(score))) return by_count;
    all_alike.rate *= crowding(T, score);
    return expected(all_alike, score, copies);
  };
  // Few that lie far apart are often enough, whatever the others do.
  constexpr std::size_t kLooked = 256;
  const Score separate =
      scorer_.score_of_separate(T, static_cast<float>(dependence_.reach), kLooked);
  const double clear = number(separate, 1);
  if (clear < kClearAtOnce) return clear;
  const double with_copies = number(scorer_.score_of_distinct(T), 1);
  if (with_copies >= kClearAtOnce) return with_copies;
  const Evidence all = evidence(T);
  return number(all.score, all.copies);
}

/// Of thin things that lie on one another residuals within the bound are not uniform: how many
/// times as many pairs of the same points, paired otherwise, agree to within what the inliers do as
/// if they were, at least.
double FalseAlarmTest::crowding(const Eigen::Isometry3d& T, const Score& score) {
  constexpr int kShifts = 16;
  if (axes().empty()) return 1;
  const double radius = radius_of(score);
  RandomStream random = random_.fork("crowding");
  double within = 0, all = 0;
  for (int k = 0; k < kShifts; ++k) {
    const auto others = static_cast<std::size_t>(scorer_.size() - 1);
    const auto shift = 1 + static_cast<int>(random.index(others));
    within += scorer_.count_shifted(T, shift, static_cast<float>(radius));
    all += scorer_.count_shifted(T, shift);
  }
  const double uniform = all * std::pow(radius, model_.dimensions);
  return uniform > 0 ? std::max(1.0, (within - 2 * std::sqrt(within)) / uniform) : 1;
}

double FalseAlarmTest::radius_of(const Score& score) const {
  return matching_radius(model_.dimensions, score.count - score.gain, score.count);
}

/// The number of the inliers alone is evidence: by a bound for grids, or as if the residuals were
/// uniform within the noise bound.
double FalseAlarmTest::expected_on_grid(const BackgroundModel& background, Score score,
                                        double copies) const {
  score.gain = score.count - matching_squares(model_.dimensions, 1, score.count);
  return std::min(
      expected(background, score, copies),
      grid_false_alarms(background.pairs / copies, background.rate / copies, score.count));
}

/// Lengths between points on a grid agree exactly or not at all, and so do the pairs at the poses
/// that bring parts of one grid onto the other, which random poses miss: whether lengths of
/// different pairs agree to within the radius more often than those of points anywhere. Residuals
/// that are not far below the noise that the bound allows for need no such look.
bool FalseAlarmTest::is_on_grid(double radius) const {
  constexpr double kFarBelowNoise = 0.3, kTimes = 3;
  constexpr int kLooked = 2000;
  if (radius > kFarBelowNoise || scorer_.size() < 4) return false;
  const PairColumns& columns = scorer_.columns();
  RandomStream random = random_.fork("lengths");
  double within = 0, all = 0;
  for (int k = 0; k < kLooked; ++k) {
    const std::array<int, 4> i = four_of(scorer_.size(), random);
    const auto off = std::abs((at(columns.s, i[0]) - at(columns.s, i[1])).norm() -
                              (at(columns.t, i[2]) - at(columns.t, i[3])).norm());
    within += off < static_cast<float>(radius);
    all += off < 1;
  }
  return within - 2 * std::sqrt(within) > kTimes * all * radius;
}

const std::vector<ThinAxes>& FalseAlarmTest::axes() {
  if (!axes_) axes_ = thin_axes(scorer_.columns());
  return *axes_;
}

double FalseAlarmTest::false_inliers(const Eigen::Isometry3d& T) const {
  constexpr int kShifts = 16;
  const int size = scorer_.size(), shifts = std::min(kShifts, size - 1);
  RandomStream random = random_.fork("false inliers");
  double hits = 0;
  for (int k = 0; k < shifts; ++k) {
    const auto shift = 1 + random.index(static_cast<std::size_t>(size - 1));
    hits += scorer_.count_shifted(T, static_cast<int>(shift));
  }
  const double wrong = 1 - static_cast<double>(scorer_.score(T).count) / size;
  return std::max(0.0, wrong) * hits / std::max(1, shifts);
}

double FalseAlarmTest::exact(const Eigen::Isometry3d& T) {
  const double number = estimate_closely(T);
  if (scorer_.dimensions() == 3 || !(number < max_false_alarms_)) return number;
  const Scorer positions = scorer_.without_normals();
  FalseAlarmTest alone(positions, max_false_alarms_, dependence_, random_);
  if (alone.quick(T) < kClearAtOnce || copies(T) == 1) return number;
  return std::max(number, alone.estimate_closely(T));
}

namespace {

/// An effort, and the number below which it decides, over the tolerated one. A few poses miss
/// places that gather much, and so make chance look too rare; with normals such places are fewer
/// and gather more: the number from 64 poses may be 1e-7 of that from many.
using Step = FalseAlarmTest::Step;
constexpr Step kPoints[] = {
    {FalseAlarmTest::kRough, 1e-6}, {FalseAlarmTest::kMedium, 1e-3}, {{512, 512}, 1}};
constexpr Step kWithNormals[] = {
    {FalseAlarmTest::kRough, 1e-13}, {FalseAlarmTest::kMedium, 1e-9}, {{2048, 512}, 1}};

}  // namespace

double FalseAlarmTest::estimate_closely(const Eigen::Isometry3d& T) {
  const double bound = quick(T);
  if (bound < kClearAtOnce) return bound;
  return scorer_.dimensions() > 3 ? estimate_in_steps(T, kWithNormals)
                                  : estimate_in_steps(T, kPoints);
}

/// With more and more effort, until the number is far from what matters.
double FalseAlarmTest::estimate_in_steps(const Eigen::Isometry3d& T, std::span<const Step> steps) {
  constexpr double kFarAbove = 100;
  double expected = 0;
  for (const Step& step : steps) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    expected = estimate(T, step.effort, &step == &steps.back() ? max_false_alarms_ : kNever);
    if (expected < step.enough_below * max_false_alarms_ ||
        expected > kFarAbove * max_false_alarms_) {
      break;
    }
  }
  return expected;
}

double FalseAlarmTest::estimate(const Eigen::Isometry3d& T, Effort effort, double enough) {
  constexpr int kMaxPoses = 4096, kFirst = 256;
  const auto [score, copies] = evidence(T);
  if (score.count <= 3) return number_of_false_alarms(model_, 0, score.count);
  if (is_on_grid(radius_of(score))) {
    return expected_on_grid(all_alike(T), score, copies);
  }
  // Of few pairs, all and at more poses.
  const int sources = std::min(effort.sources, scorer_.size() - 1);
  const int poses = std::min(kMaxPoses, effort.poses * effort.sources / sources);
  const double radius = radius_of(score);
  Rates& rates = rates_within(radius, sources);
  BackgroundModel background = model_;
  background.radius = rates.radius;
  // Further poses only add: if what is known were all there is, it might be enough already.
  const auto is_enough_at = [&](int some) {
    extend(rates, some);
    background.rate = min_power_mean(rates, T, score.count - 1, poses);
    return expected(background, score, copies) > enough;
  };
  int looked = std::isfinite(enough) ? kFirst : poses;
  while (looked < poses && !is_enough_at(looked)) looked *= 2;
  extend(rates, std::min(looked, poses));
  background.rate = power_mean(rates, T, score.count - 1);
  return expected(background, score, copies);
}

FalseAlarmTest::Rates& FalseAlarmTest::rates_within(double radius, int sources) {
  constexpr double kStep = 1.25;
  const int step = static_cast<int>(std::lround(std::log(radius) / std::log(kStep)));
  const std::pair key{step, sources};
  if (const auto known = rates_.find(key); known != rates_.end()) return known->second;
  const double rounded = std::pow(kStep, step);
  Rates rates{rounded,
              sources,
              {scorer_.columns(), scorer_.chord_bound(), rounded, axes()},
              random_.fork("poses", static_cast<std::uint64_t>(-step))};
  return rates_.emplace(key, std::move(rates)).first->second;
}

void FalseAlarmTest::extend(Rates& rates, int poses) const {
  const int step = scorer_.size() / rates.sources;
  while (static_cast<int>(rates.poses.size()) < poses) {
    const ProposedPose pose = rates.pairings.propose(rates.random);
    rates.poses.push_back(pose);
    rates.pairings.agreements(pose.T, {pose.source + 1, step, rates.sources},
                              rates.counts.emplace_back());
  }
}

/// Without the poses that are the same as T; with a bound so wide that most are, with all.
FalseAlarmTest::Powers FalseAlarmTest::powers_of(const Rates& rates, const Eigen::Isometry3d& T,
                                                 int power) const {
  std::vector<bool> is_same;
  for (const ProposedPose& pose : rates.poses) is_same.push_back(same(T, pose.T));
  const bool most = 2 * std::ranges::count(is_same, true) > std::ssize(is_same);
  Powers powers;
  for (std::size_t i = 0; i < rates.poses.size(); ++i) {
    if (is_same[i] && !most) continue;
    const auto& counts = rates.counts[i];
    const double weight = rates.poses[i].weight;
    const double estimate = weight * power_of_mean(counts, rates.sources, power);
    powers.agreements += weight * std::accumulate(counts.begin(), counts.end(), 0.0);
    powers.sum += estimate;
    powers.squares += estimate * estimate;
  }
  return powers;
}

/// The power mean of the rates at the poses that are not the same as T, and one standard error
/// more; where too few sources agree for that, the mean.
double FalseAlarmTest::power_mean(const Rates& rates, const Eigen::Isometry3d& T, int power) const {
  const Powers powers = powers_of(rates, T, power);
  const auto poses = static_cast<double>(rates.poses.size());
  const double mean_power = (powers.sum + std::sqrt(powers.squares)) / poses;
  const double mean = (1 + powers.agreements) / (poses * rates.sources);
  return std::max(mean, std::pow(mean_power, 1.0 / power)) / rates.pairings.coarseness();
}

/// No more than the power mean if there were so many poses.
double FalseAlarmTest::min_power_mean(const Rates& rates, const Eigen::Isometry3d& T, int power,
                                      int poses) const {
  const double most = std::max(static_cast<double>(poses), static_cast<double>(rates.poses.size()));
  return std::pow(powers_of(rates, T, power).sum / most, 1.0 / power) / rates.pairings.coarseness();
}

/// Whether two poses are the same answer: they move the sources alike to within three bounds, root
/// mean square. What agrees at both speaks for the same pose, not for another one by chance.
bool FalseAlarmTest::same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const {
  constexpr double kBounds = 3;
  const Eigen::Matrix3d turn = a.linear() - b.linear();
  // The sources' mean is the origin.
  const double squares = (turn * spread_ * turn.transpose()).trace() +
                         (a.translation() - b.translation()).squaredNorm();
  return squares < kBounds * kBounds;
}

}  // namespace palpate::registration
