// SPDX-License-Identifier: Apache-2.0
#include "registration/consensus.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>

#include "palpate/registration/gnc.hpp"
#include "registration/chance_judge.hpp"
#include "registration/scorer.hpp"
#include "registration/star.hpp"

namespace palpate::registration {
namespace {

constexpr int kSampleSizes[] = {64, 128, 256, 512, 1024, 2500};
// Of a sample's correspondences, all but the last's: a larger sample serves better than a long
// search of a small one.
constexpr double kSeedShare = 0.15;
constexpr std::size_t kLargeSample =
    500;  // from which on a pose is worth more than a quick judgement
constexpr int kLargestClique = 16;
// Chance proposes cliques too; those well below the largest are passed over, up to this size.
constexpr std::size_t kSurelyLarge = 8;
constexpr float kNear = 2;  // bounds, within which a slightly wrong pose brings right pairs
// Lengths of a star must agree within this many bounds, instead of the graph's 1.25.
constexpr double kStarTolerance = 0.65;
// A pose that chance proposes less often than kClear ends the search; in a small sample, by the
// quick judgement, less often than kClearAtOnce. Above kHopeless no other judgement is needed.
constexpr double kClear = 1e-4, kHopeless = 1e6;

/// `count` of 0..size-1, one from each of as many equal strata, ascending.
std::vector<int> stratified_sample(int size, int count, RandomStream random) {
  std::vector<int> sample(static_cast<std::size_t>(std::min(size, count)));
  const double width = static_cast<double>(size) / static_cast<double>(sample.size());
  for (std::size_t i = 0; i < sample.size(); ++i) {
    const double position =
        (static_cast<double>(i) + (size > count ? random.uniform() : 0)) * width;
    sample[i] = std::min(size - 1, static_cast<int>(position));
  }
  return sample;
}

/// The search over samples' stars.
class StarSearch {
 public:
  StarSearch(const Scorer& scorer, ChanceJudge& chance, const Correspondences& all,
             const ConsensusOptions& options)
      : scorer_(scorer), chance_(chance), all_(all), options_(options) {}

  /// @param seeds  how many of the sample to look around
  /// @return whether a pose was found that chance does not explain
  bool run(const std::vector<int>& sample, int seeds, RandomStream random, Consensus& best) {
    PairColumns columns;
    gather(scorer_.columns(), sample, columns);
    Star star(columns, kStarTolerance, options_.normal_noise_deg);
    std::vector<int> order(sample.size());
    std::iota(order.begin(), order.end(), 0);
    std::size_t largest = 0;
    for (int k = 0; k < seeds; ++k) {
      const auto next = static_cast<std::size_t>(k);
      std::swap(order[next], order[next + random.index(order.size() - next)]);
      star.look_around(order[next]);
      const std::vector<int> clique = clique_of(star, sample, largest);
      const bool better = !clique.empty() && propose(clique, best);
      if (exhausted(k + 1) || (better && is_clear(sample, clique))) {
        polish();
        return true;
      }
    }
    return false;
  }

  /// Whether the best pose is so good that no more needs to be looked at.
  bool is_settled() {
    if (inliers_ == 0 || judged_ == gain_) return false;
    polish();
    judged_ = gain_;
    return is_beyond_chance(kClear);
  }

  /// Judges the best pose.
  void conclude(Consensus& best) {
    if (inliers_ == 0) return;
    polish();
    best.T_target_source = scorer_.uncentred(best_);
    best.expected_by_chance = chance_.exact(best_);
    best.found = best.expected_by_chance < options_.false_alarm;
  }

 private:
  /// The star's clique in indices of the sample; empty if it is not worth a look.
  static std::vector<int> clique_of(Star& star, const std::vector<int>& sample,
                                    std::size_t& largest) {
    std::vector<int> clique = star.clique(kLargestClique);
    largest = std::max(largest, clique.size());
    if (clique.size() < 3 || clique.size() + 1 < std::min(largest, kSurelyLarge)) return {};
    for (int& vertex : clique) vertex = sample[static_cast<std::size_t>(vertex)];
    return clique;
  }

  /// Whether, of so many seeds of one sample, one of a larger consensus would have come up 99 times
  /// in 100, and the best pose is no accident.
  bool exhausted(int seeds) {
    constexpr double kLog100 = 4.6;
    if (asked_ == gain_ || seeds * inliers_ < kLog100 * scorer_.size()) return false;
    asked_ = gain_;
    return is_beyond_chance(options_.false_alarm);
  }

  /// Whether the best pose is so good that the search may end: beyond chance, and with as large a
  /// share of all as the clique that it came from has of the sample, or nearly. A pose that is
  /// right for a part, as along a line of right pairs, has less.
  bool is_clear(const std::vector<int>& sample, const std::vector<int>& clique) {
    constexpr double kNearly = 0.3;
    const double share = static_cast<double>(clique.size()) / static_cast<double>(sample.size());
    if (inliers_ < kNearly * share * scorer_.size()) return false;
    return sample.size() < kLargeSample ? quick_ < kClearAtOnce : is_beyond_chance(kClear);
  }

  /// @return whether the clique's pose is the best so far
  bool propose(const std::vector<int>& clique, Consensus& best) {
    ++best.hypotheses;
    Eigen::Isometry3d T = pose_of(clique);
    // The first pose of a clique is rough: half of the best gain is worth a refinement.
    if (scorer_.gain(T) < 0.5 * gain_) return false;
    const double gain = scorer_.descend(T);
    return keep_if_best(T, gain);
  }

  bool keep_if_best(const Eigen::Isometry3d& T, double gain) {
    if (gain <= gain_) return false;
    gain_ = gain;
    best_ = T;
    inliers_ = scorer_.score(T).count;
    quick_ = chance_.quick(T);
    return true;
  }

  /// Whether chance proposes a pose like the best less often than `level`, for all that is known
  /// at little cost.
  bool is_beyond_chance(double level) {
    if (quick_ < kClearAtOnce || quick_ > kHopeless) return quick_ < kClearAtOnce;
    const double rough = chance_.judge(best_, ChanceJudge::kRough);
    if (rough < kClearAtOnce || rough >= level) return rough < level;
    return chance_.judge(best_, ChanceJudge::kMedium) < level;
  }

  /// A part of a few inliers fits poses about the right one too: tries what becomes of the best one
  /// with wider bounds, and with other inliers.
  void polish() {
    constexpr int kFewInliers = 32, kFewer = 16, kMaxRounds = 4;
    if (inliers_ > kFewInliers) return;
    Eigen::Isometry3d wide = best_;
    for (const float reach : {3.0F, 1.7F}) scorer_.descend(wide, reach);
    const double widened = scorer_.descend(wide);
    keep_if_best(wide, widened);
    if (inliers_ > kFewer) return;
    for (int round = 0; round < kMaxRounds && exchange(); ++round) {
    }
  }

  /// Least squares after each correspondence near the best pose has joined the inliers or left
  /// them; where there are very few, also after each two.
  /// @return whether one is better
  bool exchange() {
    constexpr std::size_t kMostNear = 64, kVeryFew = 7;
    const std::vector<int> inliers = scorer_.near(best_, 1);
    std::vector<int> near = scorer_.near(best_, kNear);
    near.resize(std::min(near.size(), kMostNear));
    bool better = false;
    for (std::size_t a = 0; a < near.size(); ++a) {
      better |= refine({near[a]}, inliers);
      if (inliers.size() > kVeryFew) continue;
      for (std::size_t b = a + 1; b < near.size(); ++b)
        better |= refine({near[a], near[b]}, inliers);
    }
    return better;
  }

  /// Starts from the inliers without those of `exchanged` (ascending) among them and with the rest.
  bool refine(const std::vector<int>& exchanged, const std::vector<int>& inliers) {
    std::vector<int> changed;
    std::ranges::set_symmetric_difference(inliers, exchanged, std::back_inserter(changed));
    if (changed.size() < 3) return false;
    Eigen::Isometry3d T = scorer_.align(changed);
    const double gain = scorer_.descend(T);
    return keep_if_best(T, gain);
  }

  /// Least squares where a clique's pairs agree, else GNC on them.
  Eigen::Isometry3d pose_of(const std::vector<int>& clique) const {
    constexpr std::size_t kSmall = 6;
    const Eigen::Isometry3d T = scorer_.align(clique);
    if (clique.size() <= kSmall || scorer_.gain(T) >= 0.5 * static_cast<double>(clique.size())) {
      return T;
    }
    const GncResult gnc =
        graduated_non_convexity(subset(all_, clique), {.noise_bound = options_.noise_bound});
    return scorer_.centred(gnc.T_target_source);
  }

  const Scorer& scorer_;
  ChanceJudge& chance_;
  const Correspondences& all_;
  const ConsensusOptions& options_;
  Eigen::Isometry3d best_ = Eigen::Isometry3d::Identity();
  double gain_ = 0, quick_ = 1, judged_ = 0, asked_ = 0;
  int inliers_ = 0;  // of the best pose
};

}  // namespace

double chord_bound(const Correspondences& correspondences, double normal_noise_deg) {
  if (normal_noise_deg <= 0 || !correspondences.has_normals()) return 0;
  // Four standard deviations, as the noise bound is of a position's.
  const double angle = std::min(4 * normal_noise_deg * std::numbers::pi / 180, std::numbers::pi);
  return 2 * std::sin(angle / 2);
}

Consensus find_consensus(const Correspondences& correspondences, const ConsensusOptions& options,
                         const RandomStream& random) {
  const Scorer scorer(correspondences, options.noise_bound,
                      chord_bound(correspondences, options.normal_noise_deg));
  ChanceJudge chance(scorer, options.false_alarm, random);
  StarSearch search(scorer, chance, correspondences, options);
  Consensus best;
  best.expected_by_chance = 1;
  const int most = std::min(scorer.size(), *std::rbegin(kSampleSizes));
  for (std::uint64_t stage = 0; stage < std::size(kSampleSizes); ++stage) {
    const auto sample =
        stratified_sample(scorer.size(), kSampleSizes[stage], random.fork("sample", stage));
    const auto size = static_cast<int>(sample.size());
    const int seeds = size == most ? size : static_cast<int>(kSeedShare * size);
    if (search.run(sample, seeds, random.fork("seeds", stage), best)) break;
    if (sample.size() >= kLargeSample && search.is_settled()) break;
    if (size == most) break;
  }
  search.conclude(best);
  return best;
}

double chance_of(const Eigen::Isometry3d& T_target_source, const Correspondences& correspondences,
                 const ConsensusOptions& options, const RandomStream& random) {
  const Scorer scorer(correspondences, options.noise_bound,
                      chord_bound(correspondences, options.normal_noise_deg));
  return ChanceJudge(scorer, options.false_alarm, random).exact(scorer.centred(T_target_source));
}

}  // namespace palpate::registration
