// SPDX-License-Identifier: Apache-2.0
#include "train_demonstrations.hpp"

#include "palpate/core/error.hpp"

namespace palpate::app {

relocate::Demonstrations show(const relocate::RelocateModel& model, const relocate::Policy& expert,
                              const relocate::EpisodeOptions& episode, std::uint64_t seed,
                              std::size_t count) {
  relocate::Demonstrations demos;
  const auto horizon = static_cast<Eigen::Index>(episode.horizon);
  demos.observations.resize(relocate::kRelocateObservations, 0);
  demos.actions.resize(relocate::kRelocateJoints, 0);
  for (std::size_t i = 0; i < count; ++i) {
    relocate::RelocateTask task(model);
    relocate::Path path;
    const auto agent = [&](int, const relocate::PolicyInput& input) { return expert.act(input); };
    const auto outcome = relocate::run_episode(task, relocate::episode_start(episode, seed, i),
                                               episode.horizon, agent, &path);
    if (outcome.diverged || !(outcome.distance < 0.05)) continue;  // only successes teach
    const Eigen::Index before = demos.actions.cols();
    demos.observations.conservativeResize(Eigen::NoChange, before + horizon);
    demos.actions.conservativeResize(Eigen::NoChange, before + horizon);
    demos.observations.rightCols(horizon) = path.observations.leftCols(horizon);
    demos.actions.rightCols(horizon) = path.actions.cwiseMax(-1).cwiseMin(1);
  }
  if (demos.actions.cols() == 0)
    throw BadInput("the expert does not succeed once: nothing to show");
  return demos;
}

}  // namespace palpate::app
