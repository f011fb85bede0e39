// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/policies/velocity_observer.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"

namespace palpate::relocate {
namespace {

RelocateModel fast_model() {
  TaskOptions options;
  options.solver = "fast";
  return make_model(options);
}

StructuredPolicy reaching(const RelocateModel& model) {
  return {with_free_memory(structured_start()), model.action_center(), model.action_half_range(),
          true};
}

ObserverOptions small_fit() {
  ObserverOptions options;
  options.hidden = 24;
  options.rounds = 3;
  options.episodes = 8;
  options.samples = 60000;
  return options;
}

TEST(VelocityObserver, EstimatesTheVelocityOfTheBaseFromOneFrame) {
  const auto model = fast_model();
  EpisodeOptions episode;
  episode.horizon = 40;
  const auto fit = fit_observer({model}, reaching(model), episode, small_fit(), 3, 2);
  // The mean velocity explains nothing (0), the true one all (1).
  EXPECT_GT(fit.r2, 0.7);
  // On the frames of a new episode, under the policy that relies on it.
  const auto policy = reaching(model).variant(reaching(model).parameters(), fit.observer);
  RelocateTask task(model);
  Path path;
  run_episode(
      task, episode_start(episode, 77, 0), episode.horizon,
      [&](int, const PolicyInput& input) { return policy.act(input); }, &path);
  double error = 0;
  for (Eigen::Index i = 0; i < path.rewards.size(); ++i) {
    const auto observed = fit.observer.velocity(policy.features(path.observations.col(i)));
    error += (observed - path.velocities.col(i).head<3>()).squaredNorm();
  }
  EXPECT_LT(error, 0.5 * path.velocities.topRows<3>().squaredNorm());
}

TEST(VelocityObserver, IsTheSameForAnyNumberOfThreads) {
  const auto model = fast_model();
  EpisodeOptions episode;
  episode.horizon = 10;
  auto options = small_fit();
  options.rounds = 1;
  options.samples = 1000;
  const auto one = fit_observer({model}, reaching(model), episode, options, 5, 1);
  const auto two = fit_observer({model}, reaching(model), episode, options, 5, 2);
  EXPECT_EQ(one.observer.network.parameters(), two.observer.network.parameters());
}

TEST(VelocityObserver, NeedsARound) {
  const auto model = fast_model();
  auto options = small_fit();
  options.rounds = 0;
  EXPECT_THROW(fit_observer({model}, reaching(model), {}, options, 5, 1), BadInput);
}

}  // namespace
}  // namespace palpate::relocate
