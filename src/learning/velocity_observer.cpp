// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/velocity_observer.hpp"

#include <cmath>
#include <optional>

#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"
#include "regression_data.hpp"

namespace palpate::learning {
namespace {

constexpr double kLeastScale = 3e-3;  // so that inputs that never change do not matter
constexpr double kLargestInput = 6;   // standard deviations, as the observer clips them

StructuredPolicy with(const StructuredPolicy& policy, const Eigen::VectorXd& parameters,
                      const std::optional<StructuredPolicy::Observer>& observer) {
  return policy.variant(unflatten(parameters), observer);
}

/// Features and velocities of one episode of a perturbed policy.
RegressionData meet(const simulation::RelocateModel& model, const StructuredPolicy& policy,
                    const EpisodeOptions& episode, const simulation::RelocateStart& start) {
  simulation::RelocateTask task(model);
  Path path;
  run_episode(
      task, start, episode.horizon,
      [&](int, const PolicyInput& input) { return policy.act(input); }, &path);
  RegressionData data{Eigen::MatrixXd(StructuredPolicy::kFeatures, path.rewards.size()),
                      path.velocities.topLeftCorner(3, path.rewards.size())};
  for (Eigen::Index i = 0; i < data.inputs.cols(); ++i) {
    data.inputs.col(i) = policy.features(path.observations.col(i));
  }
  return data;
}

double explained(const StructuredPolicy::Observer& observer, const RegressionData& data) {
  double error = 0;
  for (Eigen::Index i = 0; i < data.inputs.cols(); ++i) {
    error += (observer.velocity(data.inputs.col(i)) - data.targets.col(i)).squaredNorm();
  }
  const Eigen::Vector3d center = data.targets.rowwise().mean();
  return 1 - error / (data.targets.colwise() - center).squaredNorm();
}

/// All that one round meets.
RegressionData meet_all(const simulation::RelocateModel& model, const StructuredPolicy& policy,
                        const EpisodeOptions& episode, const ObserverOptions& options,
                        std::uint64_t seed, int threads) {
  const RandomStream random(seed, "observer");
  const Eigen::VectorXd center = flatten(policy.parameters());
  const Eigen::VectorXd spread = options.perturbation * flatten(structured_spread());
  std::vector<RegressionData> parts(static_cast<std::size_t>(options.episodes));
  parallel_for(parts.size(), threads, [&](std::size_t i) {
    RandomStream own = random.fork("episode", i);
    Eigen::VectorXd moved = center;
    for (Eigen::Index k = 0; k < moved.size(); ++k) moved[k] += spread[k] * own.normal();
    parts[i] = meet(model, with(policy, moved, policy.observer()), episode,
                    episode_start(episode, seed, i));
  });
  return joined(parts);
}

}  // namespace

ObserverFit fit_observer(const simulation::RelocateModel& model, const StructuredPolicy& policy,
                         const EpisodeOptions& episode, const ObserverOptions& options,
                         std::uint64_t seed, int threads) {
  RegressionData all;
  std::optional<ObserverFit> fit;
  RandomStream random(seed, "observer fit");
  for (int round = 0; round < options.rounds; ++round) {
    const auto follow = fit ? std::optional(fit->observer) : policy.observer();
    const auto fresh =
        meet_all(model, with(policy, flatten(policy.parameters()), follow), episode, options,
                 seed + 1000003 * static_cast<std::uint64_t>(round + 1), threads);
    const double r2 = fit ? explained(fit->observer, fresh) : 0;
    all = joined({all, fresh});
    if (!fit) {
      const auto [shift, scale] = standardization(all.inputs, kLeastScale);
      Mlp network({StructuredPolicy::kFeatures, options.hidden, options.hidden, 3},
                  Activation::tanh, random);
      fit = ObserverFit{{std::move(network), shift, scale}, 0};
    }
    fit->r2 = r2;
    const auto& o = fit->observer;
    const Eigen::MatrixXd inputs =
        (o.scale.cwiseInverse().asDiagonal() * (all.inputs.colwise() - o.shift))
            .cwiseMax(-kLargestInput)
            .cwiseMin(kLargestInput);
    fit_regression(fit->observer.network, inputs, all.targets, options.regression, random);
  }
  if (!fit) throw BadInput("an observer fitted in 0 rounds");
  return *fit;
}

}  // namespace palpate::learning
