// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/gnc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpate/core/error.hpp"
#include "palpate/registration/pose.hpp"

namespace palpate::registration {
namespace {

void check_options(const GncOptions& options) {
  if (!(options.noise_bound > 0) || !std::isfinite(options.noise_bound)) {
    throw BadInput(fmt::format("noise bound {} m is not positive", options.noise_bound));
  }
  if (!(options.factor > 1))
    throw BadInput(fmt::format("factor {} is not above 1", options.factor));
  if (options.start_mu && !(*options.start_mu > 0)) {
    throw BadInput(fmt::format("start_mu {} is not positive", *options.start_mu));
  }
}

/// How much a pair is trusted.
double trust(const Correspondences& correspondences, std::size_t i) {
  return correspondences.weights.empty() ? 1 : correspondences.weights[i];
}

/// 1 for every pair that is trusted at all.
std::vector<double> first_weights(const Correspondences& correspondences) {
  std::vector<double> weights(correspondences.size(), 1);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (trust(correspondences, i) == 0) weights[i] = 0;
  }
  return weights;
}

/// Of the pairs that are trusted at all.
double largest_residual(const Correspondences& correspondences,
                        const std::vector<double>& squared) {
  double largest = 0;
  for (std::size_t i = 0; i < squared.size(); ++i) {
    if (trust(correspondences, i) > 0) largest = std::max(largest, squared[i]);
  }
  return largest;
}

/// Variable update, thesis eq. 6.16; for points the closed form is the global minimum.
/// @param weights  of GNC alone
Eigen::Isometry3d weighted_pose(const Correspondences& correspondences, std::vector<double> weights,
                                Primitive primitive) {
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] *= trust(correspondences, i);
  if (primitive == Primitive::kPoint) return align_points(correspondences, weights);
  return solve_pose(correspondences, weights, primitive).T_target_source;
}

bool binary(const std::vector<double>& weights) {
  return std::ranges::all_of(weights, [](double w) { return w < 1e-6 || w > 1 - 1e-6; });
}

bool is_tls(const GncOptions& options) {
  return options.cost == RobustCost::kTruncatedLeastSquares;
}

/// The rule that ends the loop after a weight update, if one does.
std::optional<GncStop> stop_rule(const GncOptions& options, const std::vector<double>& weights,
                                 double mu, double cost, double previous_cost) {
  if (!is_tls(options) && mu <= 1) return GncStop::kSurrogateExact;
  // With a small mu the weights start tiny: only a surrogate near its limit can reject everything.
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (is_tls(options) && mu > 1 && sum < 3) return GncStop::kNothingLeft;
  if (is_tls(options) && binary(weights)) return GncStop::kWeightsBinary;
  const double scale =
      options.noise_bound * options.noise_bound * static_cast<double>(weights.size());
  if (is_tls(options) && std::abs(cost - previous_cost) < options.cost_tolerance * scale) {
    return GncStop::kCostConverged;
  }
  return std::nullopt;
}

}  // namespace

double surrogate_cost(RobustCost cost, double squared_residual, double mu, double bound) {
  const double c2 = bound * bound, r2 = squared_residual;
  if (cost == RobustCost::kGemanMcClure) return mu * c2 * r2 / (mu * c2 + r2);
  if (r2 <= mu / (mu + 1) * c2) return r2;
  if (r2 >= (mu + 1) / mu * c2) return c2;
  return 2 * bound * std::sqrt(r2 * mu * (mu + 1)) - mu * (c2 + r2);
}

double surrogate_weight(RobustCost cost, double squared_residual, double mu, double bound) {
  const double c2 = bound * bound, r2 = squared_residual;
  if (cost == RobustCost::kGemanMcClure) {
    const double share = mu * c2 / (mu * c2 + r2);
    return share * share;
  }
  if (r2 <= mu / (mu + 1) * c2) return 1;
  if (r2 >= (mu + 1) / mu * c2) return 0;
  return std::clamp(bound * std::sqrt(mu * (mu + 1) / r2) - mu, 0.0, 1.0);
}

std::optional<double> initial_mu(RobustCost cost, double largest_squared_residual, double bound) {
  const double c2 = bound * bound;
  if (cost == RobustCost::kGemanMcClure) return 2 * largest_squared_residual / c2;
  const double denominator = 2 * largest_squared_residual - c2;
  if (denominator <= 0) return std::nullopt;
  return c2 / denominator;
}

std::string_view to_string(GncStop stop) {
  constexpr std::string_view kNames[] = {"all inliers",     "weights binary", "cost converged",
                                         "surrogate exact", "nothing left",   "max iterations"};
  return kNames[static_cast<int>(stop)];
}

GncResult graduated_non_convexity(const Correspondences& correspondences,
                                  const GncOptions& options) {
  check_options(options);
  check(correspondences, options.primitive);
  GncResult result;
  auto& [T, weights, iterations, stop, history] = result;
  weights = first_weights(correspondences);
  T = weighted_pose(correspondences, weights, options.primitive);
  auto squared = squared_residuals(correspondences, T, options.primitive);
  const auto start =
      initial_mu(options.cost, largest_residual(correspondences, squared), options.noise_bound);
  if (!start) {
    stop = GncStop::kAllInliers;
    return result;
  }
  double mu = options.start_mu.value_or(*start), previous_cost = -1;
  if (!is_tls(options)) mu = std::max(1.0, mu);
  while (iterations < options.max_iterations) {
    double cost = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double trusted = trust(correspondences, i);
      if (trusted == 0) continue;
      weights[i] = surrogate_weight(options.cost, squared[i], mu, options.noise_bound);
      cost += trusted * weights[i] * squared[i];
    }
    ++iterations;
    if (options.keep_history) history.push_back({mu, cost, weights});
    T = weighted_pose(correspondences, weights, options.primitive);
    if (const auto rule = stop_rule(options, weights, mu, cost, previous_cost)) {
      stop = *rule;
      break;
    }
    squared = squared_residuals(correspondences, T, options.primitive);
    previous_cost = cost;
    mu = is_tls(options) ? mu * options.factor : std::max(1.0, mu / options.factor);
  }
  return result;
}

}  // namespace palpate::registration
