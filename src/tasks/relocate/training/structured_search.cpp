// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/training/structured_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/tasks/relocate/training/randomization.hpp"

namespace palpate::relocate {
namespace {

constexpr double kSuccess = 0.02;             // m
constexpr double kGivenUp = -1e6;             // below any score
constexpr std::size_t kEpisodesApart = 1000;  // between the generations' episodes

std::vector<std::size_t> better_half(const std::vector<double>& scores) {
  std::vector<std::size_t> order(scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
  order.resize((order.size() + 1) / 2);
  std::sort(order.begin(), order.end());
  return order;
}

bool is_screened(const std::vector<Episode>& of_candidate, const PolicySearchOptions& options) {
  return std::ssize(of_candidate) >= options.screening;
}

bool is_whole(const std::vector<Episode>& of_candidate, const PolicySearchOptions& options) {
  return std::ssize(of_candidate) >= std::max(options.screening, options.episodes);
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

std::vector<RolloutRequest> search_requests(const SearchEpisodes& episodes,
                                            const PolicySearchOptions& options) {
  std::vector<RolloutRequest> requests;
  for (std::size_t i = 0; i < episodes.size(); ++i) {
    if (!is_screened(episodes[i], options)) requests.push_back({i, 0, options.screening});
  }
  const bool any_whole = std::ranges::any_of(
      episodes, [&](const auto& of_candidate) { return is_whole(of_candidate, options); });
  if (!requests.empty() || any_whole) return requests;
  std::vector<double> scores;
  for (const auto& of_candidate : episodes) scores.push_back(search_score(of_candidate, options));
  for (const std::size_t i : better_half(scores)) {
    requests.push_back({i, options.screening, options.episodes - options.screening});
  }
  return requests;
}

std::vector<double> search_scores(const SearchEpisodes& episodes,
                                  const PolicySearchOptions& options) {
  std::vector<double> scores;
  for (const auto& of_candidate : episodes) {
    const double score = search_score(of_candidate, options);
    scores.push_back(is_whole(of_candidate, options) ? score : score + kGivenUp);
  }
  return scores;
}

SearchEpisodes run_requests(const std::vector<RelocateModel>& worlds,
                            const std::vector<StructuredPolicy>& policies,
                            const std::vector<RolloutRequest>& requests,
                            const PolicySearchOptions& options, std::uint64_t seed, int generation,
                            int threads) {
  struct Place {
    std::size_t request, episode;
  };
  std::vector<Place> places;
  SearchEpisodes results;
  for (std::size_t k = 0; k < requests.size(); ++k) {
    const auto count = static_cast<std::size_t>(std::max(requests[k].count, 0));
    results.emplace_back(count);
    for (std::size_t i = 0; i < count; ++i) places.push_back({k, i});
  }
  const std::size_t begin = kEpisodesApart * static_cast<std::size_t>(generation);
  parallel_for(places.size(), threads, [&](std::size_t i) {
    const auto [k, episode] = places[i];
    const auto index = begin + static_cast<std::size_t>(requests[k].first) + episode;
    RelocateTask task(worlds[world_of_episode(worlds.size(), seed, index)]);
    results[k][episode] =
        run_episode(task, episode_start(options.episode, seed, index), options.episode.horizon,
                    [&](int, const PolicyInput& input) { return policies[k].act(input); });
  });
  return results;
}

void add_results(const std::vector<RolloutRequest>& requests, const SearchEpisodes& results,
                 SearchEpisodes& episodes) {
  for (std::size_t k = 0; k < requests.size(); ++k) {
    const auto& request = requests[k];
    if (k >= results.size() || std::ssize(results[k]) != request.count) {
      throw BadInput(fmt::format("candidate {}: {} episodes were asked for", request.candidate,
                                 request.count));
    }
    auto& known = episodes.at(request.candidate);
    known.insert(known.end(), results[k].begin(), results[k].end());
  }
}

learning::CemScores search_scores(const std::vector<RelocateModel>& worlds,
                                  const PolicyFactory& make_policy,
                                  const PolicySearchOptions& options, std::uint64_t seed,
                                  int generation, int threads) {
  return [=, &worlds](const std::vector<Eigen::VectorXd>& candidates) {
    SearchEpisodes episodes(candidates.size());
    while (true) {
      const auto requests = search_requests(episodes, options);
      if (requests.empty()) return search_scores(episodes, options);
      std::vector<StructuredPolicy> policies;
      for (const auto& one : requests) policies.push_back(make_policy(candidates[one.candidate]));
      add_results(requests,
                  run_requests(worlds, policies, requests, options, seed, generation, threads),
                  episodes);
    }
  };
}

}  // namespace palpate::relocate
