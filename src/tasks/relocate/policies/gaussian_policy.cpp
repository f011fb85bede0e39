// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/policies/gaussian_policy.hpp"

namespace palpate::relocate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr auto kActions = kRelocateJoints;

VectorXd precision(const MlpPolicy& policy) { return (-2 * policy.log_std()).array().exp(); }

}  // namespace

VectorXd GaussianPolicy::parameters() const {
  const VectorXd& network = policy_.network().parameters();
  VectorXd all(network.size() + kActions);
  all << network, policy_.log_std();
  return all;
}

void GaussianPolicy::set_parameters(const VectorXd& parameters, double min_log_std) {
  policy_.network().set_parameters(parameters.head(parameters.size() - kActions));
  policy_.set_log_std(parameters.tail(kActions).cwiseMax(min_log_std));
}

VectorXd GaussianPolicy::log_likelihood(const MatrixXd& observations,
                                        const MatrixXd& actions) const {
  const MatrixXd off = actions - policy_.mean(observations);
  const VectorXd square = (precision(policy_).asDiagonal() * off.cwiseAbs2()).colwise().sum();
  return -0.5 * square.array() - policy_.log_std().sum();
}

VectorXd GaussianPolicy::gradient(const MatrixXd& observations, const MatrixXd& actions,
                                  const VectorXd& weights) const {
  const double n = static_cast<double>(observations.cols());
  const auto layers = trace(observations);
  const auto& normalization = policy_.normalization();
  const MatrixXd mean = (normalization.output_scale.asDiagonal() * layers.back()).colwise() +
                        normalization.output_shift;
  const MatrixXd off = actions - mean;
  const VectorXd p = precision(policy_);
  const MatrixXd pull =
      normalization.output_scale.cwiseProduct(p).asDiagonal() * off * (weights / n).asDiagonal();
  const VectorXd spread = ((p.asDiagonal() * off.cwiseAbs2()).array() - 1).matrix() * (weights / n);
  VectorXd result(policy_.network().parameters().size() + kActions);
  result << policy_.network().gradient(layers, pull), spread;
  return result;
}

numerics::Mlp::Trace GaussianPolicy::trace(const MatrixXd& observations) const {
  return policy_.network().trace(policy_.normalized(observations));
}

VectorXd GaussianPolicy::fisher_times(const numerics::Mlp::Trace& trace,
                                      const VectorXd& vector) const {
  const double n = static_cast<double>(trace.front().cols());
  const VectorXd scale = policy_.normalization().output_scale;
  const VectorXd weight = scale.cwiseAbs2().cwiseProduct(precision(policy_)) / n;
  const MatrixXd change =
      policy_.network().directional(trace, vector.head(vector.size() - kActions));
  VectorXd result(vector.size());
  result << policy_.network().gradient(trace, weight.asDiagonal() * change),
      2 * vector.tail(kActions);
  return result;
}

double GaussianPolicy::divergence(const GaussianPolicy& other, const MatrixXd& observations) const {
  const MatrixXd apart = policy_.mean(observations) - other.policy_.mean(observations);
  const VectorXd square = apart.cwiseAbs2().rowwise().mean();
  const Eigen::ArrayXd ratio = (2 * (policy_.log_std() - other.policy_.log_std())).array().exp();
  const Eigen::ArrayXd pulled = square.array() * precision(other.policy_).array();
  return 0.5 * (ratio - 1 - ratio.log() + pulled).sum();
}

}  // namespace palpate::relocate
