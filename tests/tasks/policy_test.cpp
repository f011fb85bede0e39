// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/policies/policy.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "palpate/core/error.hpp"
#include "tasks/policies.hpp"

namespace palpate::relocate {
namespace {

numerics::Mlp network_of(int inputs, int outputs) {
  RandomStream random(1);
  return {{inputs, 4, outputs}, numerics::Activation::tanh, random};
}

const Eigen::VectorXd kLogStd = Eigen::VectorXd::Zero(30);

TEST(MlpPolicy, NormalisesItsInputsAndOutputs) {
  const MlpPolicy policy = small_network(2);
  RandomStream random(5);
  const PolicyInput input = random_input(random);
  const auto& n = policy.normalization();
  const Eigen::VectorXd x = (input.observation - n.input_shift).cwiseQuotient(n.input_scale);
  const Eigen::VectorXd expected =
      n.output_shift + n.output_scale.cwiseProduct(policy.network()(x));
  EXPECT_LT((policy.act(input) - expected).norm(), 1e-12);
}

TEST(MlpPolicy, LooksAtNothingButTheObservation) {
  const MlpPolicy policy = small_network(2);
  RandomStream random(5);
  PolicyInput input = random_input(random);
  const auto action = policy.act(input);
  input.proprioception = random_input(random).proprioception;
  EXPECT_EQ(policy.act(input), action);
}

TEST(Policy, SaysWhatItObserves) {
  const std::vector<std::string> all = {"joint_positions", "object_position", "target_position"};
  EXPECT_EQ(small_network(2).observes(), all);
  EXPECT_EQ(structured(true).observes(), all);  // its network estimates the velocity from one frame
  auto more = all;
  more.emplace_back("base_velocity");
  EXPECT_EQ(structured(false).observes(), more);
}

TEST(MlpPolicy, RejectsDimensionsThatAreNotTheTasks) {
  EXPECT_THROW(MlpPolicy(network_of(38, 30), no_normalization(), kLogStd), BadInput);
  EXPECT_THROW(MlpPolicy(network_of(39, 29), no_normalization(), kLogStd), BadInput);
  EXPECT_THROW(MlpPolicy(network_of(39, 30), no_normalization(), kLogStd.head(29)), BadInput);
  auto normalization = no_normalization();
  normalization.input_scale[3] = 0;
  EXPECT_THROW(MlpPolicy(network_of(39, 30), normalization, kLogStd), BadInput);
  normalization = no_normalization();
  normalization.output_shift[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(MlpPolicy(network_of(39, 30), normalization, kLogStd), BadInput);
}

TEST(PolicyFrom, RejectsRecordsThatDoNotFit) {
  PolicyRecord record = small_network(1).record();
  record.kind = "tree";
  EXPECT_THROW(policy_from(record), BadInput);
  record = small_network(1).record();
  record.arrays.erase("log_std");
  EXPECT_THROW(policy_from(record), BadInput);
  record = small_network(1).record();
  record.arrays["another"] = {1};
  EXPECT_THROW(policy_from(record), BadInput);
  record = structured(false).record();
  record.arrays["open"].pop_back();
  EXPECT_THROW(policy_from(record), BadInput);
}

}  // namespace
}  // namespace palpate::relocate
