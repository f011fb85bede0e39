// SPDX-License-Identifier: Apache-2.0
#include "registration/consensus.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "registration/clique_search.hpp"

namespace palpate::registration {
namespace {

constexpr int kSampleSizes[] = {64, 128, 256, 512, 1024, 2500};
// Of a sample's correspondences, all but the last's: a larger sample serves better than a long
// search of a small one.
constexpr double kSeedShare = 0.15;

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

Dependence dependence_of(const ConsensusOptions& options) {
  if (!(options.support_radius > 0)) return {};
  constexpr double kCopies = 2.0 / 3;
  const double reach = options.support_radius / options.noise_bound;
  return {reach, kCopies * reach};
}

Scorer scorer_of(const Correspondences& correspondences, const ConsensusOptions& options) {
  return {correspondences, options.noise_bound,
          chord_bound(correspondences, options.normal_noise_deg), options.turns};
}

}  // namespace

double chord_bound(const Correspondences& correspondences, double normal_noise_deg) {
  if (normal_noise_deg <= 0 || !correspondences.has_normals()) return 0;
  // Four standard deviations, as the noise bound is of a position's.
  const double angle = std::min(4 * normal_noise_deg * std::numbers::pi / 180, std::numbers::pi);
  return 2 * std::sin(angle / 2);
}

Consensus find_consensus(const Correspondences& correspondences, const ConsensusOptions& options,
                         const RandomStream& random) {
  const Scorer scorer = scorer_of(correspondences, options);
  FalseAlarmTest test(scorer, options.max_false_alarms, dependence_of(options), random);
  CliqueSearch search(scorer, test, correspondences, options);
  Consensus best;
  const int most = std::min(scorer.size(), *std::rbegin(kSampleSizes));
  for (std::uint64_t stage = 0; stage < std::size(kSampleSizes); ++stage) {
    const auto sample =
        stratified_sample(scorer.size(), kSampleSizes[stage], random.fork("sample", stage));
    const auto size = static_cast<int>(sample.size());
    const int seeds = size == most ? size : static_cast<int>(kSeedShare * size);
    if (search.run(sample, seeds, random.fork("seeds", stage), best)) break;
    if (size == most) break;
  }
  search.conclude(best);
  return best;
}

Consensus refine_consensus(const Correspondences& correspondences, const Eigen::Isometry3d& initial,
                           double reach, const ConsensusOptions& options,
                           const RandomStream& random) {
  constexpr double kNarrowing = 0.7;
  const Scorer scorer = scorer_of(correspondences, options);
  FalseAlarmTest test(scorer, options.max_false_alarms, dependence_of(options), random);
  Eigen::Isometry3d T = scorer.centred(initial);
  Consensus result;
  for (double now = reach; now > 1; now *= kNarrowing, ++result.hypotheses) {
    if (scorer.near(T, static_cast<float>(now)).size() < 3) break;
    scorer.descend(T, static_cast<float>(now));
  }
  if (scorer.near(T, 1).size() < 3) return result;
  scorer.descend(T);
  result.T_target_source = scorer.uncentred(T);
  result.false_alarms = test.exact(T);
  result.false_inliers = test.false_inliers(T);
  result.found = options.best_effort || result.false_alarms < options.max_false_alarms;
  return result;
}

double false_alarms_of(const Eigen::Isometry3d& T_target_source,
                       const Correspondences& correspondences, const ConsensusOptions& options,
                       const RandomStream& random) {
  const Scorer scorer = scorer_of(correspondences, options);
  return FalseAlarmTest(scorer, options.max_false_alarms, dependence_of(options), random)
      .exact(scorer.centred(T_target_source));
}

}  // namespace palpate::registration
