// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/progress.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/tasks/relocate/policies/policy.hpp"

namespace palpate::relocate {

/// The task as a user names it.
struct TaskOptions {
  std::string object = "mug";       ///< mug, box, bottle, ycb-mug:FILE, or a mesh file
  std::string solver = "faithful";  ///< "faithful", "newton" or "fast"
  double mass_scale = 1;
  double friction_scale = 1;
  double size = 1;    ///< of the object, times its own; its mass stays
  double mass = 0.3;  ///< of an object from a mesh file, kg

  template <class Visitor>
  void visit(Visitor&& v) {
    v("object", object,
      "manipulated object: mug (primitives), ycb-mug:FILE, box, bottle, or a mesh file in metres");
    v("solver", solver, "solver of the physics: faithful, newton or fast");
    v("mass_scale", mass_scale, 0.01, 100.0, "factor on the object's mass and inertia");
    v("friction_scale", friction_scale, 0.01, 100.0, "factor on all sliding friction");
    v("size", size, 0.5, 2.0, "factor on the object's size; its mass stays");
    v("mass", mass, 0.001, 10.0, "kg, mass of an object from a mesh file");
  }
};

/// @throws BadInput for an object that cannot be used
RelocateObject make_object(const TaskOptions& options);

/// @throws BadInput for an unknown solver, or an object that cannot be used
RelocateModel make_model(const TaskOptions& options);

/// Which episodes are run. Episode i starts the same for every policy.
struct EpisodeOptions {
  int horizon = 99;         ///< steps of 10 ms
  double scale_low = 0.25;  ///< the randomness scale is drawn again for each episode
  double scale_high = 0.25;
  double at_ends = 0;      ///< share of the episodes whose scale is one of the two, evenly
  double object_bias = 0;  ///< m, error of the object's place as observed, some way an episode
  double observation_period = 0;  ///< s between, and delay of, observations of the object in grasp
  double encoder_noise = 0;       ///< m, rad, of the encoders of the velocities; 0: the true ones

  template <class Visitor>
  void visit(Visitor&& v) {
    v("horizon", horizon, 1, 100000, "number of steps of 10 ms per episode");
    v("scale_low", scale_low, 0.0, 1.0, "least scale of the random starts");
    v("scale_high", scale_high, 0.0, 1.0, "largest scale of the random starts");
    v("at_ends", at_ends, 0.0, 1.0,
      "share of the episodes whose scale is the least or the largest");
    v("object_bias", object_bias, 0.0, 0.1,
      "m, error of the observed object's position, constant within an episode");
    v("observation_period", observation_period, 0.0, 10.0,
      "s, between two observations of the object in the grasp, and delay of each, as by touch, "
      "rounded to steps of 10 ms; 0: always the true position");
    v("encoder_noise", encoder_noise, 0.0, 0.1,
      "m, rad, noise of the encoders from which velocities are derived");
  }
};

/// What happened in one episode. A diverged one ends there and has failed.
struct Episode {
  double total = 0;     ///< return: sum of the rewards
  double distance = 0;  ///< of the object from the target at the end, m; infinite if diverged
  int steps_within_5cm = 0;
  int steps = 0;
  bool diverged = false;
};

/// What a policy met and did in one episode, one column a step.
struct Path {
  Eigen::MatrixXd observations;  ///< 39 x (steps + 1)
  Eigen::MatrixXd velocities;    ///< 30 x (steps + 1), of the joints
  Eigen::MatrixXd biases;        ///< 30 x (steps + 1), forces that hold the joints at rest
  Eigen::MatrixXd actions;       ///< 30 x steps, as the policy chose them
  Eigen::VectorXd rewards;       ///< steps
  Eigen::MatrixXd positions;     ///< 37 x (steps + 1): joints, object's place and quaternion
};

/// Where episode i of a seed starts. @throws BadInput if scale_low > scale_high, or for an
/// observation_period that is neither 0 nor at least half a step
RelocateStart episode_start(const EpisodeOptions& options, std::uint64_t seed, std::size_t index);

/// One seed that stands for episode i of a seed, in data sets and environments: seed * 2^20 + i.
/// @throws BadInput if it does not fit into 63 bits, or i into 20
std::uint64_t episode_seed(std::uint64_t seed, std::size_t index);

/// Where the episode of such a seed starts. @throws BadInput as the above
RelocateStart episode_start(const EpisodeOptions& options, std::uint64_t episode_seed);

/// What an agent does in step t, given what it meets; may explore.
using Agent = std::function<RelocateAction(int step, const PolicyInput& input)>;

/// Runs one episode. @param path  filled if not null
Episode run_episode(RelocateTask& task, const RelocateStart& start, int horizon, const Agent& agent,
                    Path* path = nullptr);

/// Runs one episode from where the task is now.
Episode continue_episode(RelocateTask& task, int horizon, const Agent& agent, Path* path = nullptr);

/// Runs a policy's mean actions over `count` episodes on up to `threads` threads.
std::vector<Episode> rollout(const RelocateModel& model, const Policy& policy,
                             const EpisodeOptions& options, std::uint64_t seed, std::size_t count,
                             int threads, const ProgressCallback& progress = {});

/// Figures of a set of episodes.
struct RolloutSummary {
  std::size_t episodes = 0, diverged = 0;
  double mean = 0, sd = 0;       ///< of the return; sd is 0 of one episode
  std::optional<Interval> ci95;  ///< of the mean (Student); none of one episode
  double success_10cm = 0, success_5cm = 0, success_2cm = 0;  ///< shares by the final distance
  double success_steady = 0;   ///< share with more than 25 steps within 5 cm
  double median_distance = 0;  ///< final, m
};

/// @throws BadInput for no episodes
RolloutSummary summarize(const std::vector<Episode>& episodes);

std::vector<double> returns(const std::vector<Episode>& episodes);

}  // namespace palpate::relocate
