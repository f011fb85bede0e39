// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/training/npg.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"
#include "tasks/policies.hpp"

namespace palpate::relocate {
namespace {

TaskOptions fast_task() {
  TaskOptions options;
  options.solver = "fast";
  return options;
}

TEST(Npg, AdvantagesByHand) {
  const Eigen::Vector3d rewards(1, 2, 3);
  const Eigen::Vector4d values(0.5, 1, -1, 2);
  // Errors of one step at a discount of 0.9: 1.4, 0.1, 5.8; each plus 0.45 times what follows.
  const auto advantages = generalized_advantages(rewards, values, 0.9, 0.5);
  EXPECT_NEAR(advantages[2], 5.8, 1e-12);
  EXPECT_NEAR(advantages[1], 0.1 + 0.45 * 5.8, 1e-12);
  EXPECT_NEAR(advantages[0], 1.4 + 0.45 * (0.1 + 0.45 * 5.8), 1e-12);
}

TEST(Npg, AdvantagesWithAFullTraceAreReturnsMinusValues) {
  const Eigen::Vector3d rewards(1, 2, 3);
  const Eigen::Vector4d values(0.5, 1, -1, 0);
  EXPECT_LT((generalized_advantages(rewards, values, 0.9, 1) -
             (discounted_returns(rewards, 0.9) - values.head<3>()))
                .norm(),
            1e-12);
}

TEST(Npg, AStepStaysWithinItsDivergenceAndImprovesTheSurrogate) {
  const auto model = make_model(fast_task());
  NpgOptions options;
  options.trajectories = 12;
  options.episode.horizon = 15;
  NpgState state;
  state.policy = small_network(1).record();
  for (int i = 0; i < 2; ++i) {
    const auto result = npg_iteration(state, model, options, {}, 3, 1);
    EXPECT_LE(result.divergence, options.divergence);
    EXPECT_GT(result.divergence, 0);
    EXPECT_GT(result.surrogate_gain, 0);
  }
  EXPECT_EQ(state.iteration, 2);
}

/// A bound of 10 allows steps so long that the divergence is far above what its curvature at the
/// start predicts.
TEST(Npg, AStepThatNoHalvingBringsWithinTheBoundIsNotTaken) {
  const auto model = make_model(fast_task());
  NpgOptions options;
  options.trajectories = 4;
  options.episode.horizon = 8;
  options.divergence = 10;
  options.min_log_std = -20;
  NpgState state;
  state.policy = small_network(1).record();
  const auto before = state.policy.arrays;
  options.halvings = 0;
  const auto result = npg_iteration(state, model, options, {}, 3, 1);
  EXPECT_EQ(result.divergence, 0);
  EXPECT_EQ(result.surrogate_gain, 0);
  EXPECT_EQ(state.policy.arrays, before);
  EXPECT_TRUE(state.value);  // the training goes on
  options.halvings = 60;
  NpgState again;
  again.policy = small_network(1).record();
  EXPECT_GT(npg_iteration(again, model, options, {}, 3, 1).divergence, 0);
  // Shortened by little at a time, the step ends close to the bound.
  options.halvings = 2000;
  options.backtrack = 0.99;
  NpgState slowly;
  slowly.policy = small_network(1).record();
  const double divergence = npg_iteration(slowly, model, options, {}, 3, 1).divergence;
  EXPECT_GT(divergence, 0.8 * options.divergence);
  EXPECT_LE(divergence, options.divergence);
}

/// The step would raise it anyhow, by a divergence that no halving removes.
TEST(Npg, AStartOfTooSmallSpreadIsRaisedBeforeTheStep) {
  const auto model = make_model(fast_task());
  NpgOptions options;
  options.trajectories = 12;
  options.episode.horizon = 15;
  auto start = small_network(1);
  Eigen::VectorXd log_std = Eigen::VectorXd::Constant(kRelocateJoints, -1);
  log_std[3] = -4;
  start.set_log_std(log_std);
  NpgState state, raised;
  state.policy = start.record();
  log_std[3] = options.min_log_std;
  start.set_log_std(log_std);
  raised.policy = start.record();
  const auto result = npg_iteration(state, model, options, {}, 3, 1);
  EXPECT_GT(result.divergence, 0);
  EXPECT_LE(result.divergence, options.divergence);
  npg_iteration(raised, model, options, {}, 3, 1);
  EXPECT_EQ(state.policy.arrays, raised.policy.arrays);
}

/// Noise of 1e308 overflows in some of the actions: these episodes end flagged. The likelihoods
/// overflow, too, so that no gradient is a number.
TEST(Npg, DivergingEpisodesAreLeftOutAndTheTrainingGoesOn) {
  const auto model = make_model(fast_task());
  NpgOptions options;
  options.trajectories = 12;
  options.episode.horizon = 3;
  NpgState state;
  Eigen::VectorXd log_std = Eigen::VectorXd::Constant(kRelocateJoints, -1);
  log_std[4] = 709.7;
  auto policy = small_network(1);
  policy.set_log_std(log_std);
  state.policy = policy.record();
  for (int i = 0; i < 2; ++i) {
    const auto result = npg_iteration(state, model, options, {}, 3, 1);
    EXPECT_GT(result.diverged, 0);
    EXPECT_LT(result.diverged, options.trajectories);
    EXPECT_EQ(result.divergence, 0);
    EXPECT_EQ(state.policy.arrays, policy.record().arrays);
    EXPECT_TRUE(state.value->parameters().allFinite());
  }
  EXPECT_EQ(state.iteration, 2);
}

TEST(Npg, IsTheSameForAnyNumberOfThreads) {
  const auto model = make_model(fast_task());
  NpgOptions options;
  options.trajectories = 4;
  options.episode.horizon = 8;
  NpgState one, three;
  one.policy = three.policy = small_network(1).record();
  npg_iteration(one, model, options, {}, 3, 1);
  npg_iteration(three, model, options, {}, 3, 3);
  EXPECT_EQ(one.policy.arrays, three.policy.arrays);
}

TEST(Npg, DemonstrationsPullThePolicyTowardsThem) {
  const auto model = make_model(fast_task());
  NpgOptions options;
  options.trajectories = 4;
  options.episode.horizon = 8;
  options.demo_weight = 100;
  Demonstrations demos;
  RandomStream random(8);
  demos.observations = Eigen::MatrixXd::NullaryExpr(39, 64, [&] { return random.normal(); });
  demos.actions = Eigen::MatrixXd::Constant(30, 64, 0.5);
  const auto policy = small_network(1);
  for (const char* form : {"published", "thesis"}) {
    options.demo_form = form;
    NpgState state;
    state.policy = policy.record();
    npg_iteration(state, model, options, demos, 3, 1);
    const auto after = policy_from(state.policy);
    const auto& network = dynamic_cast<const MlpPolicy&>(*after);
    EXPECT_LT((network.mean(demos.observations) - demos.actions).norm(),
              (policy.mean(demos.observations) - demos.actions).norm())
        << form;
  }
}

TEST(Npg, TheValueNetworkExplainsMoreOfTheReturnsTheLongerItIsFitted) {
  const auto model = make_model(fast_task());
  NpgOptions options;
  options.trajectories = 12;
  options.episode.horizon = 30;
  for (const char* inputs : {"published", "normalized"}) {
    options.value_inputs = inputs;
    NpgState state;
    state.policy = small_network(1).record();
    EXPECT_LE(npg_iteration(state, model, options, {}, 3, 1).explained, 0) << inputs;
    options.value_epochs = 60;
    NpgState longer;
    longer.policy = small_network(1).record();
    npg_iteration(longer, model, options, {}, 3, 1);
    const double after = npg_iteration(longer, model, options, {}, 3, 1).explained;
    EXPECT_GT(after, 0.3) << inputs;
    EXPECT_LE(after, 1) << inputs;
    options.value_epochs = 2;
  }
  options.value_inputs = "other";
  NpgState state;
  state.policy = small_network(1).record();
  EXPECT_THROW(npg_iteration(state, model, options, {}, 3, 1), BadInput);
}

TEST(Npg, RejectsBadDemonstrationsAndForms) {
  const auto model = make_model(fast_task());
  NpgState state;
  state.policy = small_network(1).record();
  NpgOptions options;
  options.trajectories = 1;
  options.episode.horizon = 2;
  Demonstrations demos{Eigen::MatrixXd::Zero(39, 3), Eigen::MatrixXd::Zero(30, 2)};
  EXPECT_THROW(npg_iteration(state, model, options, demos, 1, 1), BadInput);
  demos.actions = Eigen::MatrixXd::Constant(30, 3, std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(check(demos), BadInput);
  demos.actions = Eigen::MatrixXd::Zero(29, 3);
  EXPECT_THROW(check(demos), BadInput);
  options.demo_form = "other";
  EXPECT_THROW(npg_iteration(state, model, options, {}, 1, 1), BadInput);
}

TEST(CloneBehavior, CopiesALinearPolicy) {
  RandomStream random(2);
  Demonstrations demos;
  demos.observations = Eigen::MatrixXd::NullaryExpr(39, 400, [&] { return random.normal(); });
  const Eigen::MatrixXd map =
      Eigen::MatrixXd::NullaryExpr(30, 39, [&] { return 0.05 * random.normal(); });
  demos.actions = map * demos.observations;
  CloningOptions options;
  options.epochs = 60;
  options.rate = 3e-3;
  const auto policy = clone_behavior(demos, options, 1);
  // Half of the variance at the least; an untrained network explains none.
  EXPECT_LT((policy.mean(demos.observations) - demos.actions).squaredNorm(),
            0.5 * demos.actions.squaredNorm());
}

/// The likeliest standard deviation of a normal distribution is the root of the mean square.
TEST(CloneBehavior, FitsTheStandardDeviationOfEachAction) {
  RandomStream random(4);
  Demonstrations demos;
  demos.observations = Eigen::MatrixXd::NullaryExpr(39, 500, [&] { return random.normal(); });
  demos.actions = Eigen::MatrixXd::NullaryExpr(30, 500, [&] { return 0.2 * random.normal(); });
  demos.actions.row(7).setConstant(0.3);
  CloningOptions options;
  options.epochs = 40;
  options.fit_log_std = true;
  options.min_log_std = -3;
  const auto policy = clone_behavior(demos, options, 1);
  const Eigen::MatrixXd left = demos.actions - policy.mean(demos.observations);
  for (int i = 0; i < kRelocateJoints; ++i) {
    const double expected = std::max(0.5 * std::log(left.row(i).squaredNorm() / 500), -3.0);
    EXPECT_NEAR(policy.log_std()[i], expected, 1e-9) << i;
  }
  EXPECT_LT(policy.log_std()[7], policy.log_std()[8] - 0.5);
  options.std_share = 0.5;
  EXPECT_NEAR(clone_behavior(demos, options, 1).log_std()[8], policy.log_std()[8] - std::log(2.0),
              1e-9);
}

}  // namespace
}  // namespace palpate::relocate
