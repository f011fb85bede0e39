// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/training/structured_search.hpp"

#include <algorithm>
#include <numeric>

#include "palpate/core/parallel.hpp"
#include "palpate/tasks/relocate/training/randomization.hpp"

namespace palpate::relocate {
namespace {

constexpr double kSuccess = 0.02;             // m
constexpr double kGivenUp = -1e6;             // below any score
constexpr std::size_t kEpisodesApart = 1000;  // between the generations' episodes

/// Episodes of many candidates, run side by side.
class Trials {
 public:
  Trials(const std::vector<RelocateModel>& worlds, const PolicySearchOptions& options,
         std::uint64_t seed, std::size_t first, int threads)
      : worlds_(worlds), options_(options), seed_(seed), first_(first), threads_(threads) {}

  /// Runs episodes begin..end-1 of the chosen candidates and appends them.
  void run(const std::vector<StructuredPolicy>& policies, const std::vector<std::size_t>& chosen,
           int begin, int end, std::vector<std::vector<Episode>>& episodes) const {
    const auto each = static_cast<std::size_t>(std::max(end - begin, 0));
    std::vector<Episode> results(chosen.size() * each);
    parallel_for(results.size(), threads_, [&](std::size_t i) {
      const auto index = first_ + static_cast<std::size_t>(begin) + i % each;
      const auto& policy = policies[chosen[i / each]];
      RelocateTask task(worlds_[world_of_episode(worlds_.size(), seed_, index)]);
      results[i] =
          run_episode(task, episode_start(options_.episode, seed_, index), options_.episode.horizon,
                      [&](int, const PolicyInput& input) { return policy.act(input); });
    });
    for (std::size_t i = 0; i < results.size(); ++i) {
      episodes[chosen[i / each]].push_back(results[i]);
    }
  }

 private:
  const std::vector<RelocateModel>& worlds_;
  const PolicySearchOptions& options_;
  std::uint64_t seed_;
  std::size_t first_;
  int threads_;
};

std::vector<std::size_t> better_half(const std::vector<double>& scores) {
  std::vector<std::size_t> order(scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
  order.resize((order.size() + 1) / 2);
  std::sort(order.begin(), order.end());
  return order;
}

std::vector<double> scores_of(const std::vector<std::vector<Episode>>& episodes,
                              const PolicySearchOptions& options) {
  std::vector<double> scores;
  for (const auto& of_candidate : episodes) scores.push_back(search_score(of_candidate, options));
  return scores;
}

}  // namespace

double search_score(const std::vector<Episode>& episodes, const PolicySearchOptions& options) {
  const auto totals = returns(episodes);
  double successes = 0;
  for (const Episode& episode : episodes) successes += episode.distance < kSuccess;
  const double lowest = *std::min_element(totals.begin(), totals.end());
  return (1 - options.worst) * mean(totals) + options.worst * lowest +
         options.success_bonus * successes / static_cast<double>(episodes.size());
}

learning::CemScores search_scores(const std::vector<RelocateModel>& worlds,
                                  const PolicyFactory& make_policy,
                                  const PolicySearchOptions& options, std::uint64_t seed,
                                  int generation, int threads) {
  return [=, &worlds](const std::vector<Eigen::VectorXd>& candidates) {
    const Trials trials(worlds, options, seed,
                        kEpisodesApart * static_cast<std::size_t>(generation), threads);
    std::vector<StructuredPolicy> policies;
    for (const auto& candidate : candidates) policies.push_back(make_policy(candidate));
    std::vector<std::size_t> all(candidates.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    std::vector<std::vector<Episode>> episodes(candidates.size());
    trials.run(policies, all, 0, options.screening, episodes);
    auto scores = scores_of(episodes, options);
    if (options.episodes <= options.screening) return scores;
    const auto kept = better_half(scores);
    trials.run(policies, kept, options.screening, options.episodes, episodes);
    for (double& score : scores) score += kGivenUp;
    for (const std::size_t i : kept) scores[i] = search_score(episodes[i], options);
    return scores;
  };
}

}  // namespace palpate::relocate
