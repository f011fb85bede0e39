// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/training/cem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"

namespace palpate::learning {
namespace {

constexpr double kMinSpread = 1e-5;  // so that no parameter ever freezes

std::vector<Eigen::VectorXd> draw(const CemState& state, int population, RandomStream random) {
  std::vector<Eigen::VectorXd> candidates(static_cast<std::size_t>(population), state.mean);
  for (std::size_t i = 1; i < candidates.size(); ++i) {
    for (Eigen::Index k = 0; k < state.mean.size(); ++k) {
      candidates[i][k] += state.spread[k] * random.normal();
    }
  }
  return candidates;
}

/// Indices in falling order of score; a score that is NaN comes last.
std::vector<std::size_t> ranking(std::vector<double>& scores) {
  for (double& score : scores) {
    if (std::isnan(score)) score = -std::numeric_limits<double>::infinity();
  }
  std::vector<std::size_t> order(scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
  return order;
}

void check(const CemState& state, const CemOptions& options) {
  if (state.mean.size() == 0 || state.mean.size() != state.spread.size()) {
    throw BadInput(fmt::format("a search over {} parameters with {} spreads", state.mean.size(),
                               state.spread.size()));
  }
  if (options.elite > options.population) {
    throw BadInput(
        fmt::format("elite = {} is above population = {}", options.elite, options.population));
  }
}

}  // namespace

std::vector<Eigen::VectorXd> cem_candidates(const CemState& state, const CemOptions& options,
                                            std::uint64_t seed) {
  check(state, options);
  const auto index = static_cast<std::uint64_t>(state.generation);
  return draw(state, options.population, RandomStream(seed, "cem").fork("generation", index));
}

CemGeneration cem_update(CemState& state, const std::vector<Eigen::VectorXd>& candidates,
                         std::vector<double> values, const CemOptions& options) {
  check(state, options);
  if (values.size() != candidates.size()) {
    throw BadInput(fmt::format("{} scores of {} candidates", values.size(), candidates.size()));
  }
  if (std::ssize(values) < options.elite) {
    throw BadInput(
        fmt::format("{} candidates, fewer than elite = {}", values.size(), options.elite));
  }
  const auto order = ranking(values);
  if (std::isinf(values[order.front()])) throw BadInput("no candidate has a finite score");

  const Eigen::Index n = state.mean.size();
  Eigen::MatrixXd elite(n, options.elite);
  CemGeneration result{values[order.front()], 0, values.front()};
  for (Eigen::Index i = 0; i < elite.cols(); ++i) {
    elite.col(i) = candidates[order[static_cast<std::size_t>(i)]];
    result.elite += values[order[static_cast<std::size_t>(i)]] / options.elite;
  }
  const Eigen::VectorXd center = elite.rowwise().mean();
  const Eigen::VectorXd width = (elite.colwise() - center).array().square().rowwise().mean().sqrt();
  state.mean += options.step * (center - state.mean);
  state.spread =
      (options.keep_spread * state.spread + (1 - options.keep_spread) * width).array() + kMinSpread;
  ++state.generation;
  return result;
}

CemGeneration cem_generation(CemState& state, const CemScores& scores, const CemOptions& options,
                             std::uint64_t seed) {
  const auto candidates = cem_candidates(state, options, seed);
  return cem_update(state, candidates, scores(candidates), options);
}

}  // namespace palpate::learning
