// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "palpate/tasks/relocate/policies/structured_policy.hpp"

namespace palpate::relocate {

/// A policy of random weights.
inline MlpPolicy small_network(std::uint64_t seed) {
  RandomStream random(seed);
  auto normalization = no_normalization();
  normalization.input_shift.setConstant(0.1);
  normalization.input_scale.setConstant(0.3);
  normalization.output_scale.setConstant(0.7);
  numerics::Mlp network({kRelocateObservations, 6, 5, kRelocateJoints}, numerics::Activation::tanh,
                        random);
  return {std::move(network), normalization, Eigen::VectorXd::Constant(kRelocateJoints, -1)};
}

/// The structured policy that a search starts from, with or without a velocity observer.
inline StructuredPolicy structured(bool observed) {
  const auto center = RelocateAction::Constant(0.1);
  const auto half_range = RelocateAction::Constant(0.4);
  if (!observed) return {structured_start(), center, half_range, false};
  RandomStream random(9);
  const int n = StructuredPolicy::kFeatures;
  StructuredPolicy::Observer observer{numerics::Mlp({n, 4, 3}, numerics::Activation::tanh, random),
                                      Eigen::VectorXd::Zero(n), Eigen::VectorXd::Ones(n)};
  return {structured_start(), center, half_range, true, observer};
}

inline PolicyInput random_input(RandomStream& random) {
  PolicyInput input;
  for (double& value : input.observation) value = 0.3 * random.normal();
  for (double& value : input.proprioception.velocity) value = random.normal();
  for (double& value : input.proprioception.bias) value = random.normal();
  return input;
}

}  // namespace palpate::relocate
