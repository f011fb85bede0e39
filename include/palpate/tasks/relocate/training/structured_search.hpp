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
  int episodes = 6;            ///< of each of those, the screening included
  double worst = 0.2;          ///< weight of the worst episode in the score, against the mean
  double success_bonus = 500;  ///< a share of episodes that end within 2 cm is worth this return

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("cem", cem);
    v.section("episode", episode);
    v("screening", screening, 1, 10000,
      "number of episodes of every candidate; the better half is evaluated further");
    v("episodes", episodes, 1, 10000,
      "number of episodes of the better half, the screening included");
    v("worst", worst, 0.0, 1.0, "weight of the worst episode in the score");
    v("success_bonus", success_bonus, 0.0, 1e5,
      "bonus on the return for ending within 2 cm of the target");
  }
};

/// Makes a policy of a candidate's parameters.
using PolicyFactory = std::function<StructuredPolicy(const Eigen::VectorXd&)>;

/// Episodes first..first+count-1 of a candidate, which a search asks for.
struct RolloutRequest {
  std::size_t candidate = 0;
  int first = 0, count = 0;
  bool operator==(const RolloutRequest&) const = default;
};

/// The episodes of each candidate of a generation, as far as they are known.
using SearchEpisodes = std::vector<std::vector<Episode>>;

/// What a generation asks for next, in the order of the candidates: first the screening of all,
/// then the rest of the better half; none: all is known.
std::vector<RolloutRequest> search_requests(const SearchEpisodes& episodes,
                                            const PolicySearchOptions& options);

/// The score of each candidate, once nothing more is asked for.
std::vector<double> search_scores(const SearchEpisodes& episodes,
                                  const PolicySearchOptions& options);

/// Runs what is asked for, one entry a request. All candidates run the same episodes.
/// @param policies  of the requests
/// @param worlds  an episode takes place in one of them, drawn by its number
SearchEpisodes run_requests(const std::vector<RelocateModel>& worlds,
                            const std::vector<StructuredPolicy>& policies,
                            const std::vector<RolloutRequest>& requests,
                            const PolicySearchOptions& options, std::uint64_t seed, int generation,
                            int threads);

/// Adds what was asked for. @throws BadInput where a request got another number of episodes
void add_results(const std::vector<RolloutRequest>& requests, const SearchEpisodes& results,
                 SearchEpisodes& episodes);

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
