// SPDX-License-Identifier: Apache-2.0
#include "consensus.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "palpate/registration/chance.hpp"
#include "palpate/registration/consistency_graph.hpp"
#include "palpate/registration/gnc.hpp"
#include "scorer.hpp"

namespace palpate::registration {
namespace {

constexpr int kSampleSizes[] = {64, 200, 500, 1000, 2500};
constexpr int kLargeSample = 500;  // from which on a pose is worth an exact judgement
constexpr int kLargestClique = 16;
// Chance proposes cliques too; those well below the largest are passed over, up to this size.
constexpr std::size_t kSurelyLarge = 8;
// A pose through a part of the inliers may beat chance too, but its residuals fill the ball (mean
// gain 0.4, with normals 0.3); that of all has residuals of normal noise (0.8 and 0.7) and ends the
// search. Else log(100) / share of inliers more seeds follow, by which one of a larger consensus
// comes up 99 times in 100.
constexpr double kClear = 1e-11, kProven = 1e-5, kHopeless = 1e6, kTight = 0.72,
                 kTightWithNormals = 0.6, kSeeds = 4.6;

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

/// Chance of a pose, cheaply where that suffices.
class ChanceTest {
 public:
  ChanceTest(const Scorer& scorer, const Correspondences& correspondences,
             const ConsensusOptions& options, const RandomStream& random)
      : scorer_(scorer), correspondences_(correspondences), options_(options), random_(random) {}

  /// Keeps a pose that few correspondences propose, as chance does.
  void add_pose(const Eigen::Isometry3d& T) {
    if (poses_.size() < kPoses) poses_.push_back(T);
  }

  /// A pose that passes by far with this bound passes: the rate at a pose where the surfaces
  /// coincide is higher than at those that chance proposes.
  /// @param graph  of a sample of the correspondences, inliers included
  double quick_bound(const Eigen::Isometry3d& T, const ConsistencyGraph& graph) const {
    const double density3 = std::pow(graph.density(), 3);
    return expected(scorer_.score(T), triples_of(scorer_.size()) * density3, rate({T}, 4));
  }

  double operator()(const Eigen::Isometry3d& T, const ConsistencyGraph& graph) {
    const Score score = scorer_.score(T);
    const bool few = scorer_.size() <= kFew, pooled = poses_.size() == kPoses;
    if (few && wrong_triples_ < 0) wrong_triples_ = wrong_triples();
    const double triples =
        few ? std::min(scaled_triangles(graph), wrong_triples_) : scaled_triangles(graph);
    return expected(score, triples, pooled ? pooled_rate(score.count - 3) : rate({T}, 64));
  }

  static ConsistencyGraph graph_of(const Correspondences& correspondences,
                                   const ConsensusOptions& options) {
    return ConsistencyGraph(correspondences, {.noise_bound = options.noise_bound,
                                              .normal_noise_deg = options.normal_noise_deg});
  }

 private:
  static constexpr std::size_t kPoses = 32;
  // Among more than these, inliers that would raise the density are clear of chance anyway.
  static constexpr int kFew = 256;

  static double triples_of(double n) { return n * (n - 1) * (n - 2) / 6; }

  /// Triangles that a graph of all correspondences would have, one more than seen.
  double scaled_triangles(const ConsistencyGraph& graph) const {
    return (graph.triangles() + 1) * triples_of(scorer_.size()) /
           triples_of(std::max(3, graph.size()));
  }

  double expected(const Score& score, double triples, double rate) const {
    const ChanceModel model{.triples = triples, .rate = rate, .dimensions = scorer_.dimensions()};
    return expected_by_chance(model, score.count - score.gain, score.count);
  }

  /// Mean number of correspondences within the bound at the poses, were they paired anew: every
  /// source with the targets some places on.
  double rate(const std::vector<Eigen::Isometry3d>& poses, std::size_t shifts) const {
    const auto others = static_cast<std::size_t>(scorer_.size() - 1);
    RandomStream random = random_.fork("shift");
    double hits = 1, samples = 1;
    for (const Eigen::Isometry3d& T : poses) {
      for (std::size_t k = 0; k < std::min(shifts, others); ++k) {
        hits += scorer_.count_shifted(T, 1 + static_cast<int>(random.index(others)));
        samples += scorer_.size();
      }
    }
    return scorer_.size() * std::min(1.0, hits / samples);
  }

  /// The rate whose power is the mean of the pooled poses' rates to that power: some places, as
  /// large flat ones, gather far more than the mean. Of counts that are Poisson, the mean of
  /// h (h - 1) .. (h - power + 1) is the power of the rate without bias.
  double pooled_rate(int power) {
    constexpr int kShifts = 32;
    if (hits_.empty()) {
      for (const Eigen::Isometry3d& T : poses_) hits_.push_back(rate({T}, kShifts) * kShifts - 1);
    }
    double sum = 0, moment = 0;
    for (const double hits : hits_) {
      double product = 1;
      for (int i = 0; i < power; ++i) product *= std::max(0.0, hits - i) / kShifts;
      sum += hits + 1;
      moment += product;
    }
    const auto count = static_cast<double>(hits_.size());
    const double mean = sum / (count * kShifts);
    return power < 1 ? mean : std::max(mean, std::pow(moment / count, 1.0 / power));
  }

  /// Consistent triples among wrong correspondences: targets paired anew at random.
  double wrong_triples() const {
    constexpr int kPairings = 4, kVertices = 256;
    RandomStream random = random_.fork("pairing");
    double sum = 0;
    for (int k = 0; k < kPairings; ++k) {
      Correspondences wrong =
          subset(correspondences_,
                 stratified_sample(scorer_.size(), kVertices,
                                   random_.fork("wrong", static_cast<std::uint64_t>(k))));
      for (std::size_t i = 0; i + 1 < wrong.size(); ++i) {
        const std::size_t j = i + 1 + random.index(wrong.size() - i - 1);  // none stays (Sattolo)
        std::swap(wrong.target[i], wrong.target[j]);
        if (wrong.has_normals()) std::swap(wrong.target_normals[i], wrong.target_normals[j]);
      }
      sum += scaled_triangles(graph_of(wrong, options_));
    }
    return sum / kPairings;
  }

  const Scorer& scorer_;
  const Correspondences& correspondences_;
  const ConsensusOptions& options_;
  const RandomStream& random_;
  std::vector<Eigen::Isometry3d> poses_;
  std::vector<double> hits_;   // of the poses, in as many shifted pairings
  double wrong_triples_ = -1;  // not known yet
};

/// The search over one sample's cliques.
class CliqueSearch {
 public:
  CliqueSearch(const Scorer& scorer, ChanceTest& chance, const Correspondences& all,
               const ConsensusOptions& options)
      : scorer_(scorer), chance_(chance), all_(all), options_(options) {}

  /// @return whether a pose was found that chance does not explain
  bool run(const std::vector<int>& sample, Consensus& best) {
    graph_ = ChanceTest::graph_of(subset(all_, sample), options_);
    const ConsistencyGraph& graph = *graph_;
    std::vector<int> order(sample.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order,
                             [&](int a, int b) { return graph.degree(a) > graph.degree(b); });
    std::vector<bool> used(sample.size(), false);
    std::size_t largest = 0;
    for (const int seed : order) {
      if (used[static_cast<std::size_t>(seed)] || graph.degree(seed) < 2) continue;
      std::vector<int> clique = grow_clique(graph, seed, kLargestClique);
      largest = std::max(largest, clique.size());
      if (clique.size() < 3 || clique.size() + 1 < std::min(largest, kSurelyLarge)) continue;
      for (const int vertex : clique) used[static_cast<std::size_t>(vertex)] = true;
      for (int& vertex : clique) vertex = sample[static_cast<std::size_t>(vertex)];
      if (propose(clique, best) || exhausted(best)) return true;
    }
    return false;
  }

  /// Judges the best pose, exactly unless it is clear or, from what is known, hopeless.
  /// @return whether it is so good that no more needs to be looked at
  bool conclude(Consensus& best) {
    if (inliers_ == 0 || judged_ == gain_) return false;
    judged_ = gain_;
    best.T_target_source = scorer_.uncentred(best_);
    best.expected_by_chance = quick_;
    if (quick_ >= kClear && quick_ < kHopeless) {
      best.expected_by_chance = chance_(best_, *graph_);
    }
    best.found = best.expected_by_chance < options_.false_alarm;
    return best.expected_by_chance < kProven && tight();
  }

 private:
  bool propose(const std::vector<int>& clique, Consensus& best) {
    ++best.hypotheses;
    Eigen::Isometry3d T = pose_of(clique);
    chance_.add_pose(T);
    // The first pose of a clique is rough: half of the best gain is worth a refinement.
    if (scorer_.gain(T) < 0.5 * gain_) return false;
    const double gain = scorer_.descend(T);
    if (gain <= gain_) return false;
    gain_ = gain;
    best_ = T;
    inliers_ = scorer_.score(T).count;
    found_after_ = best.hypotheses;
    quick_ = chance_.quick_bound(T, *graph_);
    return quick_ < kClear && tight();
  }

  bool tight() const {
    return gain_ > (scorer_.dimensions() > 3 ? kTightWithNormals : kTight) * inliers_;
  }

  /// Whether enough seeds followed a clear pose: one of more inliers would have come up.
  bool exhausted(const Consensus& best) const {
    return quick_ < kClear && (best.hypotheses - found_after_) * inliers_ > kSeeds * scorer_.size();
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
  ChanceTest& chance_;
  const Correspondences& all_;
  const ConsensusOptions& options_;
  std::optional<ConsistencyGraph> graph_;  // of the present sample
  Eigen::Isometry3d best_ = Eigen::Isometry3d::Identity();
  double gain_ = 0, quick_ = 1, judged_ = 0;
  int inliers_ = 0, found_after_ = 0;  // of the best pose
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
  ChanceTest chance(scorer, correspondences, options, random);
  CliqueSearch search(scorer, chance, correspondences, options);
  Consensus best;
  best.expected_by_chance = 1;
  int previous = 0;
  for (std::uint64_t stage = 0; stage < std::size(kSampleSizes); ++stage) {
    const auto sample =
        stratified_sample(scorer.size(), kSampleSizes[stage], random.fork("sample", stage));
    if (static_cast<int>(sample.size()) == previous) break;
    previous = static_cast<int>(sample.size());
    if (search.run(sample, best)) break;
    if (previous >= kLargeSample && search.conclude(best)) break;
  }
  search.conclude(best);
  return best;
}

double chance_of(const Eigen::Isometry3d& T_target_source, const Correspondences& correspondences,
                 const ConsensusOptions& options, const RandomStream& random) {
  const Scorer scorer(correspondences, options.noise_bound,
                      chord_bound(correspondences, options.normal_noise_deg));
  ChanceTest chance(scorer, correspondences, options, random);
  constexpr int kVertices = 500;
  const auto sample = stratified_sample(scorer.size(), kVertices, random.fork("sample"));
  return chance(scorer.centred(T_target_source),
                ChanceTest::graph_of(subset(correspondences, sample), options));
}

}  // namespace palpate::registration
