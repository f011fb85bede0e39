// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/rollout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"
#include "tasks/relocate/relocate_scene.hpp"

namespace palpate::relocate {
namespace {

constexpr int kSteadySteps = 25;
constexpr int kIndexBits = 20;  // of an episode's seed
constexpr int kSeedBits = 43;

/// A path with room for every step of the horizon.
Path make_path(int horizon, Eigen::Index positions) {
  Path path;
  path.positions.resize(positions, horizon + 1);
  path.observations.resize(kRelocateObservations, horizon + 1);
  path.velocities.resize(kRelocateJoints, horizon + 1);
  path.biases.resize(kRelocateJoints, horizon + 1);
  path.actions.resize(kRelocateJoints, horizon);
  path.rewards.resize(horizon);
  return path;
}

void note_input(Path& path, int step, const RelocateTask& task, const PolicyInput& input) {
  path.positions.col(step) = task.positions();
  path.observations.col(step) = input.observation;
  path.velocities.col(step) = input.proprioception.velocity;
  path.biases.col(step) = input.proprioception.bias;
}

void shorten(Path& path, int steps) {
  path.observations.conservativeResize(Eigen::NoChange, steps + 1);
  path.velocities.conservativeResize(Eigen::NoChange, steps + 1);
  path.biases.conservativeResize(Eigen::NoChange, steps + 1);
  path.positions.conservativeResize(Eigen::NoChange, steps + 1);
  path.actions.conservativeResize(Eigen::NoChange, steps);
  path.rewards.conservativeResize(steps);
}

PolicyInput input_of(const RelocateTask& task) {
  return {task.observation(), task.proprioception()};
}

/// Control steps; 0 for the true position at all times. @throws BadInput where rounding makes it 0
int observation_steps(double period) {
  const auto steps = static_cast<int>(std::lround(period / kControlStep));
  if (period > 0 && steps == 0) {
    throw BadInput(
        fmt::format("observation_period = {} s is less than half a step of {} s, and would be none",
                    period, kControlStep));
  }
  return steps;
}

double share(const std::vector<Episode>& episodes, const std::function<bool(const Episode&)>& is) {
  const auto count = std::count_if(episodes.begin(), episodes.end(), is);
  return static_cast<double>(count) / static_cast<double>(episodes.size());
}

}  // namespace

RelocateStart episode_start(const EpisodeOptions& options, std::uint64_t seed, std::size_t index) {
  if (!(options.scale_low <= options.scale_high)) {
    throw BadInput(fmt::format("scale_low = {} is above scale_high = {}", options.scale_low,
                               options.scale_high));
  }
  RandomStream random = RandomStream(seed, "relocate").fork("start", index);
  double scale = random.uniform(options.scale_low, options.scale_high);
  if (options.at_ends > 0) {
    const double chance = random.uniform(0, 1);
    if (chance < options.at_ends / 2) scale = options.scale_low;
    if (chance >= 1 - options.at_ends / 2) scale = options.scale_high;
  }
  RelocateStart start = sample_relocate_start(random, scale);
  RandomStream sensors = random.fork("sensors");
  start.object_bias = options.object_bias * sensors.normal3().normalized();
  start.observation_period = observation_steps(options.observation_period);
  start.encoder_noise = options.encoder_noise;
  start.encoder_seed = sensors.bits();
  return start;
}

std::uint64_t episode_seed(std::uint64_t seed, std::size_t index) {
  if (seed >> kSeedBits != 0 || index >> kIndexBits != 0) {
    throw BadInput(fmt::format("episode {} of seed {}: below 2^{} and 2^{} are one seed", index,
                               seed, kIndexBits, kSeedBits));
  }
  return (seed << kIndexBits) | index;
}

RelocateStart episode_start(const EpisodeOptions& options, std::uint64_t episode_seed) {
  constexpr std::uint64_t kIndex = (std::uint64_t{1} << kIndexBits) - 1;
  return episode_start(options, episode_seed >> kIndexBits, episode_seed & kIndex);
}

Episode run_episode(RelocateTask& task, const RelocateStart& start, int horizon, const Agent& agent,
                    Path* path) {
  task.reset(start);
  return continue_episode(task, horizon, agent, path);
}

Episode continue_episode(RelocateTask& task, int horizon, const Agent& agent, Path* path) {
  if (path) *path = make_path(horizon, task.positions().size());
  Episode episode;
  while (episode.steps < horizon && !episode.diverged) {
    const PolicyInput input = input_of(task);
    const auto action = agent(episode.steps, input);
    if (path) note_input(*path, episode.steps, task, input);
    const auto step = task.step(action);
    if (path) {
      path->actions.col(episode.steps) = action;
      path->rewards[episode.steps] = step.reward;
    }
    ++episode.steps;
    episode.total += step.reward;
    episode.diverged = step.diverged;
    episode.distance = step.diverged ? std::numeric_limits<double>::infinity() : step.distance;
    episode.steps_within_5cm += episode.distance < 0.05;
  }
  if (path) {
    note_input(*path, episode.steps, task, input_of(task));
    shorten(*path, episode.steps);
  }
  return episode;
}

std::vector<Episode> rollout(const RelocateModel& model, const Policy& policy,
                             const EpisodeOptions& options, std::uint64_t seed, std::size_t count,
                             int threads, const ProgressCallback& progress) {
  std::vector<Episode> episodes(count);
  parallel_ordered(
      count, threads,
      [&](std::size_t index) {
        RelocateTask task(model);
        return run_episode(task, episode_start(options, seed, index), options.horizon,
                           [&](int, const PolicyInput& input) { return policy.act(input); });
      },
      [&](std::size_t index, const Episode& episode) {
        episodes[index] = episode;
        if (progress) progress(index + 1, count);
      });
  return episodes;
}

RolloutSummary summarize(const std::vector<Episode>& episodes) {
  const auto totals = returns(episodes);
  RolloutSummary summary;
  summary.episodes = episodes.size();
  summary.mean = mean(totals);
  summary.sd = totals.size() > 1 ? standard_deviation(totals) : 0;
  if (totals.size() > 1) summary.ci95 = mean_interval(totals);
  const auto within = [&](double limit) {
    return share(episodes, [limit](const Episode& e) { return e.distance < limit; });
  };
  summary.success_10cm = within(0.10);
  summary.success_5cm = within(0.05);
  summary.success_2cm = within(0.02);
  summary.success_steady =
      share(episodes, [](const Episode& e) { return e.steps_within_5cm > kSteadySteps; });
  std::vector<double> distances;
  for (const Episode& e : episodes) distances.push_back(e.distance);
  summary.median_distance = median(distances);
  summary.diverged = static_cast<std::size_t>(
      std::count_if(episodes.begin(), episodes.end(), [](const Episode& e) { return e.diverged; }));
  return summary;
}

std::vector<double> returns(const std::vector<Episode>& episodes) {
  std::vector<double> result;
  for (const Episode& episode : episodes) result.push_back(episode.total);
  return result;
}

}  // namespace palpate::relocate
