// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/policies/velocity_observer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "learning/training/regression_data.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"

namespace palpate::relocate {
namespace {

constexpr double kMinScale = 3e-3;   // so that inputs that never change do not matter
constexpr double kLargestInput = 6;  // standard deviations, as the observer clips them
constexpr int kMinEpochs = 4;

StructuredPolicy with(const StructuredPolicy& policy, const Eigen::VectorXd& parameters,
                      const std::optional<StructuredPolicy::Observer>& observer) {
  return policy.variant(unflatten(parameters), observer);
}

/// Features and velocities of one episode of a perturbed policy.
learning::RegressionData meet(const RelocateModel& model, const StructuredPolicy& policy,
                              const EpisodeOptions& episode, const RelocateStart& start) {
  RelocateTask task(model);
  Path path;
  run_episode(
      task, start, episode.horizon,
      [&](int, const PolicyInput& input) { return policy.act(input); }, &path);
  learning::RegressionData data{Eigen::MatrixXd(StructuredPolicy::kFeatures, path.rewards.size()),
                                path.velocities.topLeftCorner(3, path.rewards.size())};
  for (Eigen::Index i = 0; i < data.inputs.cols(); ++i) {
    data.inputs.col(i) = policy.features(path.observations.col(i));
  }
  return data;
}

double explained(const StructuredPolicy::Observer& observer, const learning::RegressionData& data) {
  double error = 0;
  for (Eigen::Index i = 0; i < data.inputs.cols(); ++i) {
    error += (observer.velocity(data.inputs.col(i)) - data.targets.col(i)).squaredNorm();
  }
  const Eigen::Vector3d center = data.targets.rowwise().mean();
  return 1 - error / (data.targets.colwise() - center).squaredNorm();
}

/// All that one round meets.
learning::RegressionData meet_all(const std::vector<RelocateModel>& worlds,
                                  const StructuredPolicy& policy, const EpisodeOptions& episode,
                                  const ObserverOptions& options, std::uint64_t seed, int threads) {
  const RandomStream random(seed, "observer");
  const Eigen::VectorXd center = flatten(policy.parameters());
  const Eigen::VectorXd spread = options.perturbation * flatten(structured_spread());
  std::vector<learning::RegressionData> parts(static_cast<std::size_t>(options.episodes));
  parallel_for(parts.size(), threads, [&](std::size_t i) {
    RandomStream own = random.fork("episode", i);
    Eigen::VectorXd moved = center;
    for (Eigen::Index k = 0; k < moved.size(); ++k) moved[k] += spread[k] * own.normal();
    parts[i] = meet(worlds[i % worlds.size()], with(policy, moved, policy.observer()), episode,
                    episode_start(episode, seed, i));
  });
  return learning::joined(parts);
}

StructuredPolicy::Observer new_observer(const learning::RegressionData& data, int hidden,
                                        RandomStream& random) {
  auto [shift, scale] = learning::standardization(data.inputs, kMinScale);
  numerics::Mlp network({StructuredPolicy::kFeatures, hidden, hidden, 3},
                        numerics::Activation::tanh, random);
  return {std::move(network), std::move(shift), std::move(scale)};
}

void teach(StructuredPolicy::Observer& observer, const learning::RegressionData& data, int samples,
           RandomStream& random) {
  const Eigen::MatrixXd inputs =
      (observer.scale.cwiseInverse().asDiagonal() * (data.inputs.colwise() - observer.shift))
          .cwiseMax(-kLargestInput)
          .cwiseMin(kLargestInput);
  numerics::RegressionOptions options{0, 128, 2e-3, 0.05, 0};
  options.epochs = std::max(kMinEpochs, samples / static_cast<int>(inputs.cols()));
  numerics::fit_regression(observer.network, inputs, data.targets, options, random);
}

}  // namespace

ObserverFit fit_observer(const std::vector<RelocateModel>& worlds, const StructuredPolicy& policy,
                         const EpisodeOptions& episode, const ObserverOptions& options,
                         std::uint64_t seed, int threads) {
  if (options.rounds < 1) throw BadInput(fmt::format("an observer of {} rounds", options.rounds));
  learning::RegressionData all;
  std::optional<StructuredPolicy::Observer> observer = policy.observer();
  double r2 = 0;
  RandomStream random(seed, "observer fit");
  for (int round = 0; round < options.rounds; ++round) {
    const auto fresh =
        meet_all(worlds, with(policy, flatten(policy.parameters()), observer), episode, options,
                 seed + 1000003 * static_cast<std::uint64_t>(round + 1), threads);
    if (fresh.inputs.cols() == 0) throw BadInput("an observer without any frame to learn from");
    if (observer) r2 = explained(*observer, fresh);
    all = learning::joined({all, fresh});
    if (!observer) observer = new_observer(all, options.hidden, random);
    teach(*observer, all, options.samples, random);
  }
  return {std::move(*observer), r2};
}

}  // namespace palpate::relocate
