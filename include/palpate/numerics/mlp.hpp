// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "palpate/core/random.hpp"

namespace palpate::numerics {

enum class Activation { tanh, relu, sigmoid };

/// A small fully connected network of floats or doubles: affine layers with an activation between
/// them, the last one linear. All parameters lie in one vector, layer by layer: weights (out x in,
/// column by column), then biases.
template <class Scalar>
class BasicMlp {
 public:
  using Matrix = Eigen::MatrixX<Scalar>;
  using Vector = Eigen::VectorX<Scalar>;

  /// @param sizes  inputs, hidden units..., outputs
  /// Weights start uniform within 1/sqrt(inputs of the layer), biases at 0.
  /// @throws BadInput for fewer than two sizes, or one below 1
  BasicMlp(std::vector<int> sizes, Activation activation, palpate::RandomStream& random);

  /// From known parameters. @throws BadInput also unless their number fits and all are finite
  BasicMlp(std::vector<int> sizes, Activation activation, Vector parameters);

  const std::vector<int>& sizes() const { return sizes_; }
  Activation activation() const { return activation_; }
  const Vector& parameters() const { return parameters_; }
  /// @throws BadInput unless their number fits
  void set_parameters(const Vector& parameters);

  /// Outputs (outputs x n) of a batch of inputs (inputs x n). @throws BadInput for another height
  Matrix operator()(const Matrix& inputs) const;

  /// The outputs of every layer, the inputs first.
  using Trace = std::vector<Matrix>;
  Trace trace(const Matrix& inputs) const;

  /// Gradient with respect to the parameters of a sum over the batch whose gradient with respect to
  /// the outputs is given (outputs x n). Backpropagation (Rumelhart et al. 1986).
  /// @param input_gradient  where given, receives the gradient with respect to the inputs
  Vector gradient(const Trace& trace, const Matrix& output_gradient,
                  Matrix* input_gradient = nullptr) const;

  /// Change of the outputs when the parameters change along a direction (Pearlmutter 1994).
  Matrix directional(const Trace& trace, const Vector& direction) const;

 private:
  Matrix derivative(const Matrix& outputs) const;

  std::vector<int> sizes_;
  Activation activation_;
  Vector parameters_;
};
using Mlp = BasicMlp<double>;
using FloatMlp = BasicMlp<float>;

/// Weights and biases of one layer, a view of all parameters.
template <class Scalar>
struct MlpLayer {
  Eigen::Map<Eigen::MatrixX<Scalar>> weights;  ///< out x in
  Eigen::Map<Eigen::VectorX<Scalar>> biases;
};

Eigen::Index count_parameters(const std::vector<int>& sizes);

/// The layers of a network of these sizes. @param parameters  count_parameters(sizes) values
template <class Scalar>
std::vector<MlpLayer<Scalar>> mlp_layers(const std::vector<int>& sizes,
                                         Eigen::VectorX<Scalar>& parameters);

/// Steps of gradient descent with momentum, scaled by each gradient's size (Kingma & Ba 2015).
template <class Scalar>
class BasicAdam {
 public:
  using Vector = Eigen::VectorX<Scalar>;

  BasicAdam(Eigen::Index parameters, Scalar rate, Scalar weight_decay = 0);

  void set_rate(Scalar rate) { rate_ = rate; }
  /// The parameters after a step down the gradient of a loss.
  Vector step(const Vector& parameters, const Vector& gradient);

 private:
  Scalar rate_, weight_decay_;
  Scalar decayed_first_ = 1, decayed_second_ = 1;  // powers of the decay rates
  Vector first_, second_;                          // moments
};
using Adam = BasicAdam<double>;
using FloatAdam = BasicAdam<float>;

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
