// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/training/npg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>
#include <utility>

#include "learning/training/regression_data.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"
#include "tasks/relocate/policies/gaussian_policy.hpp"

namespace palpate::relocate {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of the published implementation (mjrl; Rajeswaran et al. 2018), but for kTimeUnit: mjrl divides
// the step by 1000.
constexpr double kAdvantageScale = 1e-2;
constexpr double kLargestObservation = 10, kTimeUnit = 100;
constexpr int kTimePowers = 4;
constexpr double kLargestNormalized = 5;
constexpr int kValueUnits = 128, kValueBatch = 64;
constexpr double kValueRate = 1e-3, kValueDecay = 1e-3;

/// The paths of an iteration, end to end.
struct Batch {
  MatrixXd observations, actions, features;
  VectorXd advantages, returns;
};

MatrixXd clipped(const MatrixXd& values, double limit) {
  return values.cwiseMax(-limit).cwiseMin(limit);
}

/// Inputs of the value network: the clipped observation and powers of time.
MatrixXd value_features(const MatrixXd& observations, const MlpPolicy& policy,
                        const std::string& inputs) {
  MatrixXd features(observations.rows() + kTimePowers, observations.cols());
  if (inputs == "published") {
    features.topRows(observations.rows()) =
        clipped(observations, kLargestObservation) / kLargestObservation;
  } else if (inputs == "normalized") {
    features.topRows(observations.rows()) =
        clipped(policy.normalized(observations), kLargestNormalized);
  } else {
    throw BadInput(fmt::format("value_inputs = '{}': published or normalized is known", inputs));
  }
  for (Index i = 0; i < observations.cols(); ++i) {
    const double t = static_cast<double>(i) / kTimeUnit;
    for (int power = 1; power <= kTimePowers; ++power) {
      features(observations.rows() + power - 1, i) = std::pow(t, power);
    }
  }
  return features;
}

std::vector<Path> explore(const NpgState& state, const RelocateModel& model,
                          const MlpPolicy& policy, const NpgOptions& options, std::uint64_t seed,
                          int threads, NpgIteration& result) {
  const auto count = static_cast<std::size_t>(options.trajectories);
  const RandomStream random =
      RandomStream(seed, "explore").fork("iteration", static_cast<std::uint64_t>(state.iteration));
  const VectorXd std = policy.log_std().array().exp();
  std::vector<Path> paths(count);
  std::vector<Episode> episodes(count);
  parallel_for(count, threads, [&](std::size_t i) {
    RandomStream noise = random.fork("episode", i);
    RelocateTask task(model);
    const auto start =
        episode_start(options.episode, seed, count * static_cast<std::size_t>(state.iteration) + i);
    const Agent agent = [&](int, const PolicyInput& input) {
      RelocateAction action = policy.act(input);
      for (Index k = 0; k < action.size(); ++k) action[k] += std[k] * noise.normal();
      return action;
    };
    episodes[i] = run_episode(task, start, options.episode.horizon, agent, &paths[i]);
  });
  std::vector<Path> whole;
  for (std::size_t i = 0; i < count; ++i) {
    const bool usable = !episodes[i].diverged && paths[i].rewards.allFinite();
    if (usable) whole.push_back(std::move(paths[i]));
    result.diverged += !usable;
  }
  if (whole.empty()) throw BadInput(fmt::format("all {} episodes diverged", count));
  const auto summary = summarize(episodes);
  result.mean_return = summary.mean;
  result.success_5cm = summary.success_5cm;
  return whole;
}

VectorXd predicted(const NpgState& state, const MatrixXd& features) {
  if (!state.value) return VectorXd::Zero(features.cols());
  return ((*state.value)(features).row(0).array() * state.value_scale + state.value_shift).matrix();
}

/// Share of the variance of `values` that `estimates` explain; below 0 where they do worse than a
/// constant.
double explained_share(const VectorXd& values, const VectorXd& estimates) {
  const double variance = (values.array() - values.mean()).square().mean();
  return variance > 0 ? 1 - (values - estimates).squaredNorm() /
                                static_cast<double>(values.size()) / variance
                      : 0;
}

Batch gather(const NpgState& state, const MlpPolicy& policy, const std::vector<Path>& paths,
             const NpgOptions& options, NpgIteration& result) {
  Index steps = 0;
  for (const Path& path : paths) steps += path.rewards.size();
  Batch batch{MatrixXd(kRelocateObservations, steps), MatrixXd(kRelocateJoints, steps),
              MatrixXd(kRelocateObservations + kTimePowers, steps), VectorXd(steps),
              VectorXd(steps)};
  VectorXd predictions(steps);
  Index next = 0;
  for (const Path& path : paths) {
    const Index n = path.rewards.size();
    const MatrixXd features = value_features(path.observations, policy, options.value_inputs);
    const VectorXd values = predicted(state, features);
    batch.observations.middleCols(next, n) = path.observations.leftCols(n);
    batch.actions.middleCols(next, n) = path.actions;
    batch.features.middleCols(next, n) = features.leftCols(n);
    batch.advantages.segment(next, n) =
        generalized_advantages(path.rewards, values, options.discount, options.trace);
    batch.returns.segment(next, n) = discounted_returns(path.rewards, options.discount);
    predictions.segment(next, n) = values.head(n);
    next += n;
  }
  result.explained = explained_share(batch.returns, predictions);
  batch.advantages.array() -= batch.advantages.mean();
  const double spread = std::sqrt(batch.advantages.squaredNorm() / static_cast<double>(steps));
  if (spread > 0) batch.advantages /= spread;
  return batch;
}

/// Solves (F + damping) x = g (Hestenes & Stiefel 1952).
VectorXd natural_gradient(const GaussianPolicy& policy, const MatrixXd& observations,
                          const VectorXd& gradient, const NpgOptions& options) {
  const auto trace = policy.trace(observations);
  VectorXd x = VectorXd::Zero(gradient.size()), residual = gradient, direction = gradient;
  double square = residual.squaredNorm();
  for (int i = 0; i < options.conjugate_steps && square > 1e-20; ++i) {
    const VectorXd curved = policy.fisher_times(trace, direction) + options.damping * direction;
    const double step = square / direction.dot(curved);
    x += step * direction;
    residual -= step * curved;
    const double next = residual.squaredNorm();
    direction = residual + next / square * direction;
    square = next;
  }
  return x;
}

double demo_weight(const NpgOptions& options, int iteration, double largest_advantage) {
  const double weight = options.demo_weight * std::pow(options.demo_decay, iteration);
  if (options.demo_form == "published") return weight;
  if (options.demo_form == "thesis") return weight * largest_advantage;
  throw BadInput(fmt::format("demo_form = '{}': published or thesis is known", options.demo_form));
}

/// Gradient of eq. 7.3: on the batch, weighted by advantages, and on the demonstrations.
VectorXd augmented_gradient(const GaussianPolicy& policy, const Batch& batch,
                            const Demonstrations& demos, double weight) {
  const double n = static_cast<double>(batch.observations.cols());
  const double d = static_cast<double>(demos.observations.cols());
  VectorXd sum =
      n * policy.gradient(batch.observations, batch.actions, kAdvantageScale * batch.advantages);
  if (d > 0 && weight > 0) {
    const VectorXd weights =
        VectorXd::Constant(demos.observations.cols(), kAdvantageScale * weight);
    sum += d * policy.gradient(demos.observations, demos.actions, weights);
  }
  return sum / (n + d);
}

/// Raises standard deviations below the least one. A step from there would raise them, too, by more
/// than its divergence allows however short it is.
void raise_log_std(GaussianPolicy& policy, double min_log_std) {
  if (policy.policy().log_std().minCoeff() >= min_log_std) return;
  policy.set_parameters(policy.parameters(), min_log_std);
}

/// Moves the policy along the natural gradient as far as the divergence allows; not at all if no
/// halving of the step meets it.
void take_step(GaussianPolicy& policy, const Batch& batch, const VectorXd& gradient,
               const NpgOptions& options, NpgIteration& result) {
  const GaussianPolicy before = policy;
  const VectorXd direction = natural_gradient(policy, batch.observations, gradient, options);
  const double slope = gradient.dot(direction);
  if (!(slope > 0)) return;
  double length = std::sqrt(2 * options.divergence / slope);
  for (int i = 0; i <= options.halvings; ++i, length *= options.backtrack) {
    policy.set_parameters(before.parameters() + length * direction, options.min_log_std);
    result.divergence = before.divergence(policy, batch.observations);
    if (result.divergence <= options.divergence) break;
  }
  if (!(result.divergence <= options.divergence)) {  // also if it is NaN
    policy = before;
    result.divergence = 0;
    return;
  }
  const Eigen::ArrayXd ratio = (policy.log_likelihood(batch.observations, batch.actions) -
                                before.log_likelihood(batch.observations, batch.actions))
                                   .array()
                                   .exp();
  result.surrogate_gain = ((ratio - 1) * batch.advantages.array()).mean();
}

void fit_value(NpgState& state, const Batch& batch, int epochs, RandomStream random) {
  if (!state.value) {
    state.value_shift = batch.returns.mean();
    const double variance = (batch.returns.array() - state.value_shift).square().mean();
    state.value_scale = std::max(std::sqrt(variance), 1.0);
    state.value.emplace(
        std::vector<int>{static_cast<int>(batch.features.rows()), kValueUnits, kValueUnits, 1},
        numerics::Activation::relu, random);
  }
  const MatrixXd targets =
      ((batch.returns.array() - state.value_shift) / state.value_scale).matrix().transpose();
  numerics::RegressionOptions regression{epochs, kValueBatch, kValueRate, 1, kValueDecay};
  numerics::fit_regression(*state.value, batch.features, targets, regression, random);
}

MlpPolicy mlp_policy(const PolicyRecord& record) {
  const auto policy = policy_from(record);
  const auto* mlp = dynamic_cast<const MlpPolicy*>(policy.get());
  if (!mlp) throw BadInput(fmt::format("a policy of kind '{}' has no gradient", record.kind));
  return *mlp;
}

}  // namespace

VectorXd generalized_advantages(const VectorXd& rewards, const VectorXd& values, double discount,
                                double trace) {
  VectorXd result(rewards.size());
  double sum = 0;
  for (Index i = rewards.size(); i-- > 0;) {
    sum = rewards[i] + discount * values[i + 1] - values[i] + discount * trace * sum;
    result[i] = sum;
  }
  return result;
}

VectorXd discounted_returns(const VectorXd& rewards, double discount) {
  VectorXd result(rewards.size());
  double sum = 0;
  for (Index i = rewards.size(); i-- > 0;) {
    sum = rewards[i] + discount * sum;
    result[i] = sum;
  }
  return result;
}

NpgIteration npg_iteration(NpgState& state, const RelocateModel& model, const NpgOptions& options,
                           const Demonstrations& demonstrations, std::uint64_t seed, int threads) {
  check(demonstrations);
  NpgIteration result;
  GaussianPolicy policy(mlp_policy(state.policy));
  raise_log_std(policy, options.min_log_std);
  const auto paths = explore(state, model, policy.policy(), options, seed, threads, result);
  const Batch batch = gather(state, policy.policy(), paths, options, result);
  const double weight = demo_weight(options, state.iteration, batch.advantages.maxCoeff());
  const VectorXd gradient = augmented_gradient(policy, batch, demonstrations, weight);
  take_step(policy, batch, gradient, options, result);
  fit_value(
      state, batch, options.value_epochs,
      RandomStream(seed, "value").fork("iteration", static_cast<std::uint64_t>(state.iteration)));
  state.policy = policy.policy().record();
  ++state.iteration;
  return result;
}

void check(const Demonstrations& demonstrations) {
  const auto& [observations, actions] = demonstrations;
  if (observations.size() == 0 && actions.size() == 0) return;
  if (observations.cols() != actions.cols() || observations.rows() != kRelocateObservations ||
      actions.rows() != kRelocateJoints) {
    throw BadInput(fmt::format("demonstrations of {} x {} observations and {} x {} actions",
                               observations.rows(), observations.cols(), actions.rows(),
                               actions.cols()));
  }
  if (!observations.allFinite() || !actions.allFinite()) {
    throw BadInput("demonstrations with a value that is not finite");
  }
}

MlpPolicy clone_behavior(const Demonstrations& demonstrations, const CloningOptions& options,
                         std::uint64_t seed) {
  constexpr double kLeastScale = 0.01;
  check(demonstrations);
  RandomStream random(seed, "cloning");
  auto normalization = no_normalization();
  const bool shown = demonstrations.observations.cols() > 0;
  if (shown) {
    std::tie(normalization.input_shift, normalization.input_scale) =
        learning::standardization(demonstrations.observations, kLeastScale);
  }
  MlpPolicy policy(
      numerics::Mlp({kRelocateObservations, options.hidden, options.hidden, kRelocateJoints},
                    numerics::Activation::tanh, random),
      normalization, VectorXd::Constant(kRelocateJoints, options.log_std));
  if (shown) {
    numerics::RegressionOptions regression;
    regression.epochs = options.epochs;
    regression.rate = options.rate;
    numerics::fit_regression(policy.network(), policy.normalized(demonstrations.observations),
                             demonstrations.actions, regression, random);
    if (options.fit_log_std) {
      const MatrixXd left = demonstrations.actions - policy.mean(demonstrations.observations);
      const Eigen::ArrayXd spread = left.array().square().rowwise().mean().sqrt();
      const Eigen::ArrayXd log_std = (options.std_share * spread + 1e-300).log();
      policy.set_log_std(log_std.max(options.min_log_std).matrix());
    }
  }
  return policy;
}

}  // namespace palpate::relocate
