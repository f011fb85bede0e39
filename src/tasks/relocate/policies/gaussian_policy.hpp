// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "palpate/tasks/relocate/policies/policy.hpp"

namespace palpate::relocate {

/// An MLP policy as a normal distribution of actions. Its parameters are those of the network, then
/// the logarithms of the standard deviations.
class GaussianPolicy {
 public:
  explicit GaussianPolicy(MlpPolicy policy) : policy_(std::move(policy)) {}

  const MlpPolicy& policy() const { return policy_; }
  Eigen::VectorXd parameters() const;
  /// @param min_log_std  to which smaller ones are raised
  void set_parameters(const Eigen::VectorXd& parameters, double min_log_std);

  /// Log-likelihood of each action, without its constant part.
  Eigen::VectorXd log_likelihood(const Eigen::MatrixXd& observations,
                                 const Eigen::MatrixXd& actions) const;

  /// Gradient of the mean of weight * log-likelihood.
  Eigen::VectorXd gradient(const Eigen::MatrixXd& observations, const Eigen::MatrixXd& actions,
                           const Eigen::VectorXd& weights) const;

  /// Fisher information, averaged over the observations, times a vector.
  Eigen::VectorXd fisher_times(const numerics::Mlp::Trace& trace,
                               const Eigen::VectorXd& vector) const;
  numerics::Mlp::Trace trace(const Eigen::MatrixXd& observations) const;

  /// Mean Kullback-Leibler divergence of another policy from this one.
  double divergence(const GaussianPolicy& other, const Eigen::MatrixXd& observations) const;

 private:
  MlpPolicy policy_;
};

}  // namespace palpate::relocate
