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

/// Weights and biases of one layer within all parameters.
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

auto layers_of(const std::vector<int>& sizes, const VectorXd& parameters) {
  return split<const VectorXd, const MatrixXd>(sizes, parameters.data());
}

auto layers_of(const std::vector<int>& sizes, VectorXd& parameters) {
  return split<VectorXd, MatrixXd>(sizes, parameters.data());
}

Index count_parameters(const std::vector<int>& sizes) {
  Index sum = 0;
  for (std::size_t i = 0; i + 1 < sizes.size(); ++i) {
    sum += Index{sizes[i + 1]} * (Index{sizes[i]} + 1);
  }
  return sum;
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

void activate(Activation activation, MatrixXd& values) {
  if (activation == Activation::tanh) {
    values = values.array().tanh();
  } else {
    values = values.cwiseMax(0);
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

Mlp::Mlp(std::vector<int> sizes, Activation activation, palpate::RandomStream& random)
    : sizes_(std::move(sizes)), activation_(activation) {
  check_sizes(sizes_);
  parameters_ = VectorXd::Zero(count_parameters(sizes_));
  for (auto& layer : layers_of(sizes_, parameters_)) {
    const double bound = 1 / std::sqrt(static_cast<double>(layer.weights.cols()));
    for (double& weight : layer.weights.reshaped()) weight = random.uniform(-bound, bound);
  }
}

Mlp::Mlp(std::vector<int> sizes, Activation activation, VectorXd parameters)
    : sizes_(std::move(sizes)), activation_(activation) {
  check_sizes(sizes_);
  set_parameters(parameters);
  if (!parameters_.allFinite())
    throw palpate::BadInput("a network with parameters that are not finite");
}

void Mlp::set_parameters(const VectorXd& parameters) {
  if (parameters.size() != count_parameters(sizes_)) {
    throw palpate::BadInput(fmt::format("{} parameters for a network that has {}",
                                        parameters.size(), count_parameters(sizes_)));
  }
  parameters_ = parameters;
}

Mlp::Trace Mlp::trace(const MatrixXd& inputs) const {
  if (inputs.rows() != sizes_.front()) {
    throw palpate::BadInput(
        fmt::format("{} inputs for a network that has {}", inputs.rows(), sizes_.front()));
  }
  const auto layers = layers_of(sizes_, parameters_);
  Trace result = {inputs};
  for (std::size_t i = 0; i < layers.size(); ++i) {
    MatrixXd values = layers[i].weights * result.back();
    values.colwise() += layers[i].biases;
    if (i + 1 < layers.size()) activate(activation_, values);
    result.push_back(std::move(values));
  }
  return result;
}

MatrixXd Mlp::operator()(const MatrixXd& inputs) const { return std::move(trace(inputs).back()); }

MatrixXd Mlp::derivative(const MatrixXd& outputs) const {
  if (activation_ == Activation::tanh) return 1 - outputs.array().square();
  return (outputs.array() > 0).cast<double>();
}

VectorXd Mlp::gradient(const Trace& trace, const MatrixXd& output_gradient) const {
  const auto layers = layers_of(sizes_, parameters_);
  VectorXd result(parameters_.size());
  auto gradients = layers_of(sizes_, result);
  MatrixXd delta = output_gradient;
  for (std::size_t i = layers.size(); i-- > 0;) {
    gradients[i].weights.noalias() = delta * trace[i].transpose();
    gradients[i].biases = delta.rowwise().sum();
    if (i > 0) {
      delta = (layers[i].weights.transpose() * delta).cwiseProduct(derivative(trace[i])).eval();
    }
  }
  return result;
}

MatrixXd Mlp::directional(const Trace& trace, const VectorXd& direction) const {
  const auto layers = layers_of(sizes_, parameters_);
  const auto changes = layers_of(sizes_, direction);
  MatrixXd change = MatrixXd::Zero(trace.front().rows(), trace.front().cols());
  for (std::size_t i = 0; i < layers.size(); ++i) {
    change = (layers[i].weights * change + changes[i].weights * trace[i]).eval();
    change.colwise() += changes[i].biases;
    if (i + 1 < layers.size()) change = change.cwiseProduct(derivative(trace[i + 1])).eval();
  }
  return change;
}

Adam::Adam(Index parameters, double rate, double weight_decay)
    : rate_(rate),
      weight_decay_(weight_decay),
      first_(VectorXd::Zero(parameters)),
      second_(VectorXd::Zero(parameters)) {}

VectorXd Adam::step(const VectorXd& parameters, const VectorXd& gradient) {
  const VectorXd g = gradient + weight_decay_ * parameters;
  decayed_first_ *= kFirstDecay;
  decayed_second_ *= kSecondDecay;
  first_ = kFirstDecay * first_ + (1 - kFirstDecay) * g;
  second_ = kSecondDecay * second_ + (1 - kSecondDecay) * g.cwiseAbs2();
  const auto size = (second_.array() / (1 - decayed_second_)).sqrt() + kTiny;
  return parameters - rate_ / (1 - decayed_first_) * (first_.array() / size).matrix();
}

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
