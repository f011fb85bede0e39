// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "palpate/core/random.hpp"

namespace palpate::numerics {

enum class Activation { tanh, relu };

/// A small fully connected network: affine layers with an activation between them, the last one
/// linear. All parameters lie in one vector, layer by layer: weights (out x in, column by column),
/// then biases.
class Mlp {
 public:
  /// @param sizes  inputs, hidden units..., outputs
  /// Weights start uniform within 1/sqrt(inputs of the layer), biases at 0.
  /// @throws BadInput for fewer than two sizes, or one below 1
  Mlp(std::vector<int> sizes, Activation activation, palpate::RandomStream& random);

  /// From known parameters. @throws BadInput also unless their number fits and all are finite
  Mlp(std::vector<int> sizes, Activation activation, Eigen::VectorXd parameters);

  const std::vector<int>& sizes() const { return sizes_; }
  Activation activation() const { return activation_; }
  const Eigen::VectorXd& parameters() const { return parameters_; }
  /// @throws BadInput unless their number fits
  void set_parameters(const Eigen::VectorXd& parameters);

  /// Outputs (outputs x n) of a batch of inputs (inputs x n). @throws BadInput for another height
  Eigen::MatrixXd operator()(const Eigen::MatrixXd& inputs) const;

  /// The outputs of every layer, the inputs first.
  using Trace = std::vector<Eigen::MatrixXd>;
  Trace trace(const Eigen::MatrixXd& inputs) const;

  /// Gradient with respect to the parameters of a sum over the batch whose gradient with respect to
  /// the outputs is given (outputs x n). Backpropagation (Rumelhart et al. 1986).
  Eigen::VectorXd gradient(const Trace& trace, const Eigen::MatrixXd& output_gradient) const;

  /// Change of the outputs when the parameters change along a direction (Pearlmutter 1994).
  Eigen::MatrixXd directional(const Trace& trace, const Eigen::VectorXd& direction) const;

 private:
  Eigen::MatrixXd derivative(const Eigen::MatrixXd& outputs) const;

  std::vector<int> sizes_;
  Activation activation_;
  Eigen::VectorXd parameters_;
};

/// Steps of gradient descent with momentum, scaled by each gradient's size (Kingma & Ba 2015).
class Adam {
 public:
  Adam(Eigen::Index parameters, double rate, double weight_decay = 0);

  void set_rate(double rate) { rate_ = rate; }
  /// The parameters after a step down the gradient of a loss.
  Eigen::VectorXd step(const Eigen::VectorXd& parameters, const Eigen::VectorXd& gradient);

 private:
  double rate_, weight_decay_;
  double decayed_first_ = 1, decayed_second_ = 1;  // powers of the decay rates
  Eigen::VectorXd first_, second_;                 // moments
};

struct RegressionOptions {
  int epochs = 50;
  int batch = 64;
  double rate = 1e-3;        ///< of Adam, at the start
  double final_rate = 0.05;  ///< share of it that is left at the end; in between linear
  double weight_decay = 0;   ///< added to the gradient, times the parameters
};

/// Fits the network to targets (outputs x n) by mean squared error, in shuffled batches.
/// @return mean squared error of an output over the last epoch
/// @throws BadInput if there is nothing to fit, sizes differ, or a value is not finite
double fit_regression(Mlp& network, const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& targets,
                      const RegressionOptions& options, palpate::RandomStream& random);

}  // namespace palpate::numerics
