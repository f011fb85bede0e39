// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "consensus.hpp"
#include "palpate/registration/consistency_graph.hpp"
#include "scorer.hpp"

namespace palpate::registration {

/// `count` of 0..size-1, one from each of as many equal strata, ascending.
std::vector<int> stratified_sample(int size, int count, RandomStream random);

/// Number of triples of n things.
inline double triples_of(double n) { return n * (n - 1) * (n - 2) / 6; }

/// Chance of a pose, cheaply where that suffices.
///
/// `triples` are those of all correspondences that the consistency graph joins.
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
  double quick_bound(const Eigen::Isometry3d& T, double triples) const;

  double operator()(const Eigen::Isometry3d& T, double triples);

  /// Whether the judgement costs little: many correspondences, and poses to compare with.
  bool ready() const { return scorer_.size() > kFew && poses_.size() >= kEnoughPoses; }

  /// Triples of all correspondences, one more than seen, from the graph of a sample.
  double triples_from(const ConsistencyGraph& graph) const;

 private:
  static constexpr std::size_t kPoses = 32, kEnoughPoses = 16;
  // Among more than these, inliers that would raise the density are clear of chance anyway.
  static constexpr int kFew = 256;

  double expected(const Score& score, double triples, double rate) const;
  double rate(const std::vector<Eigen::Isometry3d>& poses, std::size_t shifts) const;
  double pooled_rate(int power);
  double wrong_triples() const;

  const Scorer& scorer_;
  const Correspondences& correspondences_;
  const ConsensusOptions& options_;
  const RandomStream& random_;
  std::vector<Eigen::Isometry3d> poses_;
  std::vector<double> hits_;   // of the poses, in as many shifted pairings
  double wrong_triples_ = -1;  // not known yet
};

/// The graph whose triples ChanceTest counts.
ConsistencyGraph graph_of(const Correspondences& correspondences, const ConsensusOptions& options);

}  // namespace palpate::registration
