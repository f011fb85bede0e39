// SPDX-License-Identifier: Apache-2.0
#include "palpate/numerics/mlp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate::numerics {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFirstDecay = 0.9, kSecondDecay = 0.999, kTiny = 1e-8;

/// As MlpLayer, of parameters that may be constant.
template <class Vector, class Matrix>
struct Layer {
  Eigen::Map<Matrix> weights;
  Eigen::Map<Vector> biases;
};

template <class Vector, class Matrix, class Scalar>
std::vector<Layer<Vector, Matrix>> split(const std::vector<int>& sizes, Scalar* next) {
  std::vector<Layer<Vector, Matrix>> layers;
  for (std::size_t i = 0; i + 1 < sizes.size(); ++i) {
    const Index in = sizes[i], out = sizes[i + 1];
    layers.push_back({Eigen::Map<Matrix>(next, out, in), Eigen::Map<Vector>(next + out * in, out)});
    next += out * in + out;
  }
  return layers;
}

template <class Scalar>
auto layers_of(const std::vector<int>& sizes, const Eigen::VectorX<Scalar>& parameters) {
  return split<const Eigen::VectorX<Scalar>, const Eigen::MatrixX<Scalar>>(sizes,
                                                                           parameters.data());
}

void check_sizes(const std::vector<int>& sizes) {
  if (sizes.size() < 2) {
    throw palpate::BadInput(
        fmt::format("a network of {} layer sizes, at least 2 needed", sizes.size()));
  }
  for (const int size : sizes) {
    if (size < 1) throw palpate::BadInput(fmt::format("a network with a layer of {} units", size));
  }
}

template <class Matrix>
void activate(Activation activation, Matrix& values) {
  if (activation == Activation::tanh) {
    values = values.array().tanh();
  } else if (activation == Activation::relu) {
    values = values.cwiseMax(0);
  } else {
    values = (1 / (1 + (-values.array()).exp())).matrix();
  }
}

void shuffle(std::vector<Index>& order, palpate::RandomStream& random) {
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.index(i)]);
}

MatrixXd columns(const MatrixXd& matrix, const Index* first, Index count) {
  MatrixXd result(matrix.rows(), count);
  for (Index i = 0; i < count; ++i) result.col(i) = matrix.col(first[i]);
  return result;
}

void check_regression(const Mlp& network, const MatrixXd& inputs, const MatrixXd& targets) {
  if (inputs.cols() == 0 || inputs.cols() != targets.cols() ||
      inputs.rows() != network.sizes().front() || targets.rows() != network.sizes().back()) {
    throw palpate::BadInput(
        fmt::format("inputs {} x {} and targets {} x {} for a network of {} inputs and {} "
                    "outputs",
                    inputs.rows(), inputs.cols(), targets.rows(), targets.cols(),
                    network.sizes().front(), network.sizes().back()));
  }
  if (!inputs.allFinite() || !targets.allFinite()) {
    throw palpate::BadInput("a regression on values that are not finite");
  }
}

}  // namespace

Index count_parameters(const std::vector<int>& sizes) {
  Index sum = 0;
  for (std::size_t i = 0; i + 1 < sizes.size(); ++i) {
    sum += Index{sizes[i + 1]} * (Index{sizes[i]} + 1);
  }
  return sum;
}

template <class Scalar>
std::vector<MlpLayer<Scalar>> mlp_layers(const std::vector<int>& sizes,
                                         Eigen::VectorX<Scalar>& parameters) {
  std::vector<MlpLayer<Scalar>> layers;
  for (auto& layer :
       split<Eigen::VectorX<Scalar>, Eigen::MatrixX<Scalar>>(sizes, parameters.data())) {
    layers.push_back({layer.weights, layer.biases});
  }
  return layers;
}

template <class Scalar>
BasicMlp<Scalar>::BasicMlp(std::vector<int> sizes, Activation activation,
                           palpate::RandomStream& random)
    : sizes_(std::move(sizes)), activation_(activation) {
  check_sizes(sizes_);
  parameters_ = Vector::Zero(count_parameters(sizes_));
  for (auto& layer : mlp_layers(sizes_, parameters_)) {
    const double bound = 1 / std::sqrt(static_cast<double>(layer.weights.cols()));
    for (Scalar& weight : layer.weights.reshaped()) {
      weight = static_cast<Scalar>(random.uniform(-bound, bound));
    }
  }
}

template <class Scalar>
BasicMlp<Scalar>::BasicMlp(std::vector<int> sizes, Activation activation, Vector parameters)
    : sizes_(std::move(sizes)), activation_(activation) {
  check_sizes(sizes_);
  set_parameters(parameters);
  if (!parameters_.allFinite())
    throw palpate::BadInput("a network with parameters that are not finite");
}

template <class Scalar>
void BasicMlp<Scalar>::set_parameters(const Vector& parameters) {
  if (parameters.size() != count_parameters(sizes_)) {
    throw palpate::BadInput(fmt::format("{} parameters for a network that has {}",
                                        parameters.size(), count_parameters(sizes_)));
  }
  parameters_ = parameters;
}

template <class Scalar>
typename BasicMlp<Scalar>::Trace BasicMlp<Scalar>::trace(const Matrix& inputs) const {
  if (inputs.rows() != sizes_.front()) {
    throw palpate::BadInput(
        fmt::format("{} inputs for a network that has {}", inputs.rows(), sizes_.front()));
  }
  const auto layers = layers_of(sizes_, parameters_);
  Trace result = {inputs};
  for (std::size_t i = 0; i < layers.size(); ++i) {
    Matrix values = layers[i].weights * result.back();
    values.colwise() += layers[i].biases;
    if (i + 1 < layers.size()) activate(activation_, values);
    result.push_back(std::move(values));
  }
  return result;
}

template <class Scalar>
typename BasicMlp<Scalar>::Matrix BasicMlp<Scalar>::operator()(const Matrix& inputs) const {
  return std::move(trace(inputs).back());
}

template <class Scalar>
typename BasicMlp<Scalar>::Matrix BasicMlp<Scalar>::derivative(const Matrix& outputs) const {
  if (activation_ == Activation::tanh) return 1 - outputs.array().square();
  if (activation_ == Activation::sigmoid) return outputs.array() * (1 - outputs.array());
  return (outputs.array() > 0).template cast<Scalar>();
}

template <class Scalar>
typename BasicMlp<Scalar>::Vector BasicMlp<Scalar>::gradient(const Trace& trace,
                                                             const Matrix& output_gradient,
                                                             Matrix* input_gradient) const {
  const auto layers = layers_of(sizes_, parameters_);
  Vector result(parameters_.size());
  auto gradients = mlp_layers(sizes_, result);
  Matrix delta = output_gradient;
  for (std::size_t i = layers.size(); i-- > 0;) {
    gradients[i].weights.noalias() = delta * trace[i].transpose();
    gradients[i].biases = delta.rowwise().sum();
    if (i > 0) {
      delta = (layers[i].weights.transpose() * delta).cwiseProduct(derivative(trace[i])).eval();
    }
  }
  if (input_gradient) *input_gradient = layers.front().weights.transpose() * delta;
  return result;
}

template <class Scalar>
typename BasicMlp<Scalar>::Matrix BasicMlp<Scalar>::directional(const Trace& trace,
                                                                const Vector& direction) const {
  const auto layers = layers_of(sizes_, parameters_);
  const auto changes = layers_of(sizes_, direction);
  Matrix change = Matrix::Zero(trace.front().rows(), trace.front().cols());
  for (std::size_t i = 0; i < layers.size(); ++i) {
    change = (layers[i].weights * change + changes[i].weights * trace[i]).eval();
    change.colwise() += changes[i].biases;
    if (i + 1 < layers.size()) change = change.cwiseProduct(derivative(trace[i + 1])).eval();
  }
  return change;
}

template <class Scalar>
BasicAdam<Scalar>::BasicAdam(Index parameters, Scalar rate, Scalar weight_decay)
    : rate_(rate),
      weight_decay_(weight_decay),
      first_(Vector::Zero(parameters)),
      second_(Vector::Zero(parameters)) {}

template <class Scalar>
typename BasicAdam<Scalar>::Vector BasicAdam<Scalar>::step(const Vector& parameters,
                                                           const Vector& gradient) {
  constexpr auto kFirst = static_cast<Scalar>(kFirstDecay);
  constexpr auto kSecond = static_cast<Scalar>(kSecondDecay);
  const Vector g = gradient + weight_decay_ * parameters;
  decayed_first_ *= kFirst;
  decayed_second_ *= kSecond;
  first_ = kFirst * first_ + (1 - kFirst) * g;
  second_ = kSecond * second_ + (1 - kSecond) * g.cwiseAbs2();
  const auto size = (second_.array() / (1 - decayed_second_)).sqrt() + static_cast<Scalar>(kTiny);
  return parameters - rate_ / (1 - decayed_first_) * (first_.array() / size).matrix();
}

template class BasicMlp<double>;
template class BasicMlp<float>;
template class BasicAdam<double>;
template class BasicAdam<float>;
template std::vector<MlpLayer<double>> mlp_layers(const std::vector<int>&, VectorXd&);
template std::vector<MlpLayer<float>> mlp_layers(const std::vector<int>&, Eigen::VectorXf&);

double fit_regression(Mlp& network, const MatrixXd& inputs, const MatrixXd& targets,
                      const RegressionOptions& options, palpate::RandomStream& random) {
  check_regression(network, inputs, targets);
  Adam adam(network.parameters().size(), options.rate, options.weight_decay);
  std::vector<Index> order(static_cast<std::size_t>(inputs.cols()));
  std::iota(order.begin(), order.end(), Index{0});
  double error = 0;
  for (int epoch = 0; epoch < options.epochs; ++epoch) {
    shuffle(order, random);
    error = 0;
    adam.set_rate(options.rate * (1 - (1 - options.final_rate) * epoch / options.epochs));
    for (Index start = 0; start < inputs.cols(); start += options.batch) {
      const Index count = std::min<Index>(options.batch, inputs.cols() - start);
      const auto trace = network.trace(columns(inputs, order.data() + start, count));
      const MatrixXd difference = trace.back() - columns(targets, order.data() + start, count);
      error += difference.squaredNorm();
      network.set_parameters(adam.step(
          network.parameters(),
          network.gradient(trace, 2.0 / static_cast<double>(difference.size()) * difference)));
    }
  }
  return error / static_cast<double>(targets.size());
}

}  // namespace palpate::numerics
