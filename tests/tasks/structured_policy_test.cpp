// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/policies/structured_policy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"
#include "tasks/policies.hpp"

namespace palpate::relocate {
namespace {

TEST(StructuredPolicy, FlattensAndUnflattens) {
  Eigen::VectorXd values = flatten(structured_start());
  for (Eigen::Index i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i);
  EXPECT_EQ(flatten(unflatten(values)), values);
  EXPECT_EQ(flatten(structured_spread()).size(), values.size());
  EXPECT_THROW(unflatten(values.head(5)), BadInput);
}

TEST(StructuredPolicy, EverySpreadIsPositive) {
  EXPECT_GT(flatten(structured_spread()).minCoeff(), 0);
}

TEST(StructuredPolicy, AnObservedPolicyLooksAtNothingButTheObservation) {
  const auto policy = structured(true);
  RandomStream random(4);
  for (int i = 0; i < 50; ++i) {
    PolicyInput input = random_input(random);
    const auto action = policy.act(input);
    input.proprioception = random_input(random).proprioception;
    EXPECT_EQ(policy.act(input), action);
  }
}

TEST(StructuredPolicy, AVelocityReadingPolicyBrakes) {
  const auto policy = structured(false);
  PolicyInput input;
  input.observation.setZero();
  input.observation.segment<3>(30) << 0, -0.15, 0.08;  // the palm is behind the object
  const double at_rest = policy.act(input).z();        // the base's z pushes along +y
  input.proprioception.velocity.setZero();
  input.proprioception.velocity[2] = 0.5;
  EXPECT_LT(policy.act(input).z(), at_rest);
}

TEST(StructuredPolicy, OpensFarAwayAndClosesNearTheObject) {
  const auto policy = structured(false);
  const auto& p = policy.parameters();
  PolicyInput input;
  input.observation.setZero();
  input.observation.segment<3>(30) << 0, -0.5, 0.1;
  EXPECT_LT((policy.act(input).tail<24>() - p.open.cwiseMax(-1).cwiseMin(1)).norm(), 0.1);
  input.observation.segment<3>(30) = p.grasp_offset;
  EXPECT_LT((policy.act(input).tail<24>() - p.closed.cwiseMax(-1).cwiseMin(1)).norm(), 0.1);
}

/// The same policy with other parameters.
StructuredPolicy with(const StructuredParameters& parameters) {
  return {parameters, RelocateAction::Constant(0.1), RelocateAction::Constant(0.4), false};
}

TEST(StructuredPolicy, AlignKeepsTheHandOpenUntilItStandsInLine) {
  auto parameters = structured_start();
  PolicyInput input;
  input.observation.setZero();
  const double beside = 2 * std::abs(parameters.close[0]) / 3;
  const auto closed = [&](double align, const Eigen::Vector3d& away) {
    parameters.align.setConstant(align);
    input.observation.segment<3>(30) = parameters.grasp_offset + away;
    const auto action = with(parameters).act(input);
    const auto& p = parameters;
    return (action.tail<24>() - p.open.cwiseMax(-1).cwiseMin(1)).norm();
  };
  EXPECT_LT(closed(3, {beside, 0, 0}), closed(1, {beside, 0, 0}));
  EXPECT_DOUBLE_EQ(closed(3, {0, beside, 0}), closed(1, {0, beside, 0}));
}

TEST(StructuredPolicy, TheReachPushesNoHarderThanItsLimit) {
  auto parameters = structured_start();
  PolicyInput input;
  input.observation.setZero();
  const auto push = [&](double limit, double behind) {
    parameters.limits[0] = limit;
    input.observation.segment<3>(30) << 0, -behind, 0.1;
    return with(parameters).act(input)[2];  // the base's z pushes along +y
  };
  parameters.reach_gains[0] = 10;  // so that no action reaches its own limit
  EXPECT_NEAR(push(0.05, 0.5), push(0.05, 0.6), 1e-6);
  EXPECT_GT(push(0.10, 0.6), push(0.05, 0.6));
}

TEST(StructuredPolicy, ActionsStayWithinTheirRange) {
  RandomStream random(6);
  for (const bool observed : {false, true}) {
    const auto policy = structured(observed);
    for (int i = 0; i < 100; ++i) {
      EXPECT_LE(policy.act(random_input(random)).cwiseAbs().maxCoeff(), 1);
    }
  }
}

TEST(StructuredPolicy, RejectsWhatCannotAct) {
  auto parameters = structured_start();
  const auto center = RelocateAction::Zero().eval();
  const auto ones = RelocateAction::Ones().eval();
  EXPECT_THROW(StructuredPolicy(parameters, center, center, false), BadInput);
  parameters.limits[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(StructuredPolicy(parameters, center, ones, false), BadInput);
  RandomStream random(1);
  StructuredPolicy::Observer observer{numerics::Mlp({5, 3}, numerics::Activation::tanh, random),
                                      Eigen::VectorXd::Zero(5), Eigen::VectorXd::Ones(5)};
  EXPECT_THROW(StructuredPolicy(structured_start(), center, ones, true, observer), BadInput);
}

}  // namespace
}  // namespace palpate::relocate
