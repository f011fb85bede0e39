// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/learning/training/cem.hpp"
#include "palpate/tasks/relocate/policies/structured_policy.hpp"
#include "palpate/tasks/relocate/rollout.hpp"

namespace palpate::relocate {

struct PolicySearchOptions {
  learning::CemOptions cem;
  EpisodeOptions episode;
  int screening = 2;           ///< episodes of every candidate; the better half goes on
  int episodes = 6;            ///< of each of those
  double worst = 0.2;          ///< weight of the worst episode in the score, against the mean
  double success_bonus = 500;  ///< a share of episodes that end within 2 cm is worth this return

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("cem", cem);
    v.section("episode", episode);
    v("screening", screening, 1, 10000, "episodes of every candidate; the better half goes on");
    v("episodes", episodes, 1, 10000, "of each of those");
    v("worst", worst, 0.0, 1.0, "weight of the worst episode in the score, against the mean");
    v("success_bonus", success_bonus, 0.0, 1e5, "return that ending within 2 cm is worth");
  }
};

/// Makes a policy of a candidate's parameters.
using PolicyFactory = std::function<StructuredPolicy(const Eigen::VectorXd&)>;

/// Scores of a generation's candidates: all run the same episodes, other generations others. Half
/// of them are given up after the screening and rank below the rest. Mean return alone would trade
/// success for it, so the score also counts the worst episode and success.
/// @param worlds  an episode takes place in one of them, drawn by its number
learning::CemScores search_scores(const std::vector<RelocateModel>& worlds,
                                  const PolicyFactory& make_policy,
                                  const PolicySearchOptions& options, std::uint64_t seed,
                                  int generation, int threads);

/// Score of some episodes of one policy.
double search_score(const std::vector<Episode>& episodes, const PolicySearchOptions& options);

}  // namespace palpate::relocate
