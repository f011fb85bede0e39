// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "palpate/tasks/relocate/rollout.hpp"

namespace palpate::relocate {

/// Frames and what was done in them, one a column.
struct Demonstrations {
  Eigen::MatrixXd observations;  ///< 39 x n
  Eigen::MatrixXd actions;       ///< 30 x n
};

struct NpgOptions {
  EpisodeOptions episode;
  int trajectories = 200;    ///< episodes an iteration
  double discount = 0.995;   ///< gamma
  double trace = 0.97;       ///< lambda of generalised advantages
  double divergence = 0.01;  ///< Kullback-Leibler divergence of a step
  int halvings = 10;         ///< how often a step that goes further is shortened, at most
  double backtrack = 0.5;    ///< factor by which it is shortened
  int conjugate_steps = 10;  ///< of conjugate gradients
  double damping = 1e-4;     ///< added to the Fisher information
  double min_log_std = -3;   ///< of the actions; a start below it is raised to it
  double demo_weight = 0.1;  ///< lambda 0 of the demonstrations
  double demo_decay = 0.99;  ///< lambda 1, a factor an iteration
  /// "published": the demonstrations' weight is lambda0 lambda1^k; "thesis": that times the largest
  /// advantage (eq. 7.5).
  std::string demo_form = "published";
  /// What the value network sees of an observation: "published": a tenth of it; "normalized": as
  /// the policy's network does. Either with four powers of time.
  std::string value_inputs = "published";
  int value_epochs = 2;  ///< over an iteration's frames
  int evaluation = 10;   ///< episodes of the mean action that a trainer runs after each iteration

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("episode", episode);
    v("trajectories", trajectories, 1, 1000000, "number of episodes per iteration");
    v("discount", discount, 0.0, 1.0, "discount factor gamma");
    v("trace", trace, 0.0, 1.0, "lambda of the generalised advantage estimate");
    v("divergence", divergence, 1e-9, 10.0, "Kullback-Leibler divergence of a step");
    v("halvings", halvings, 0, 100,
      "number of halvings of a step that exceeds the divergence, at most");
    v("conjugate_steps", conjugate_steps, 1, 1000, "number of conjugate gradient steps");
    v("damping", damping, 0.0, 10.0, "damping added to the Fisher information");
    v("min_log_std", min_log_std, -20.0, 2.0,
      "least logarithm of the standard deviation of the actions; a start below it is raised to it");
    v("demo_weight", demo_weight, 0.0, 100.0, "weight lambda_0 of the demonstrations");
    v("demo_decay", demo_decay, 0.0, 1.0, "factor lambda_1 on that weight per iteration");
    v("demo_form", demo_form,
      "weighting of demonstrations: published, or thesis (times the largest advantage, eq. 7.5)");
    v("evaluation", evaluation, 1, 100000,
      "number of episodes with the mean action after each iteration");
    v("backtrack", backtrack, 0.01, 0.99,
      "factor by which a step that exceeds the divergence is shortened");
    v("value_inputs", value_inputs,
      "inputs of the value network: published (a tenth of an observation), or normalized");
    v("value_epochs", value_epochs, 1, 1000,
      "number of passes of the value network over the frames of an iteration");
  }
};

/// What an iteration leaves behind.
struct NpgState {
  int iteration = 0;
  PolicyRecord policy;                      ///< of kind "mlp"
  std::optional<numerics::Mlp> value;       ///< none before the first iteration
  double value_shift = 0, value_scale = 1;  ///< of the returns that it was first fitted to
};

struct NpgIteration {
  double mean_return = 0, success_5cm = 0;  ///< of the exploring policy
  double surrogate_gain = 0;  ///< of the mean advantage-weighted likelihood ratio, by the step
  double divergence = 0;      ///< of the step
  double explained = 0;       ///< share of the returns' variance that the value network predicted
  int diverged = 0;           ///< episodes that were left out
};

/// One iteration of the natural policy gradient (Kakade 2001; Rajeswaran et al. 2018; thesis eqs
/// 7.3-7.5): explores, estimates advantages (Schulman et al. 2016) against a value network, steps
/// along F^-1 g at a bounded divergence, and fits the value network. Episodes that diverged, or
/// whose rewards are not finite, are left out.
/// @throws BadInput if all episodes diverged, for an unknown demo_form, or if the demonstrations'
///         sizes do not fit or hold a value that is not finite
NpgIteration npg_iteration(NpgState& state, const RelocateModel& model, const NpgOptions& options,
                           const Demonstrations& demonstrations, std::uint64_t seed, int threads);

/// Generalised advantages of one path. @param values  of its steps and of what comes after, n + 1
Eigen::VectorXd generalized_advantages(const Eigen::VectorXd& rewards,
                                       const Eigen::VectorXd& values, double discount,
                                       double trace);

/// Discounted sums of the rewards from each step on.
Eigen::VectorXd discounted_returns(const Eigen::VectorXd& rewards, double discount);

struct CloningOptions {
  int hidden = 32;  ///< units of each of two hidden layers
  int epochs = 200;
  double rate = 1e-3;  ///< of numerics::Adam
  double log_std = 0;  ///< of the actions of the policy that is made
  /// Takes instead the log standard deviation that makes the demonstrations likeliest (eq. 7.2):
  /// that of what is left of each action, but no less than min_log_std.
  bool fit_log_std = false;
  double min_log_std = -4;
  double std_share = 1;  ///< of the standard deviations found so that one explores with
  template <class Visitor>
  void visit(Visitor&& v) {
    v("hidden", hidden, 1, 1024, "number of units in each of the two hidden layers");
    v("epochs", epochs, 0, 1000000, "number of passes over all frames");
    v("rate", rate, 1e-6, 1.0, "learning rate of Adam");
    v("log_std", log_std, -10.0, 2.0,
      "logarithm of the standard deviation of the actions of the new policy");
    v("fit_log_std", fit_log_std,
      "take the standard deviations that make the demonstrations likeliest instead of log_std");
    v("min_log_std", min_log_std, -20.0, 2.0,
      "least logarithm of the standard deviations found in this way");
    v("std_share", std_share, 1e-3, 100.0, "factor on the standard deviations found in this way");
  }
};

/// A network that copies demonstrations (behaviour cloning, eq. 7.2); its inputs are normalised by
/// them. Without any frames, or with 0 epochs, its weights are random.
/// @throws BadInput as npg_iteration for the demonstrations
MlpPolicy clone_behavior(const Demonstrations& demonstrations, const CloningOptions& options,
                         std::uint64_t seed);

/// @throws BadInput unless there are as many actions as observations, of the task's sizes, all
///         finite
void check(const Demonstrations& demonstrations);

}  // namespace palpate::relocate
