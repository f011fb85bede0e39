// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/biotac/network.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "palpate/core/array_file.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "tactile/biotac/backpropagation.hpp"

namespace palpate::tactile {
namespace {

constexpr const char* kNetworkKind = "biotac-network";
constexpr int kNetworkVersion = 1;

const std::array<std::vector<int>, 4> kShapes = {std::vector<int>{3, 512, 512, 512, 64},
                                                 {9, 256, 256, 256, 64},
                                                 {1, 256, 23},
                                                 {64, 256, 256, 23}};

/// A block with weights uniform within sqrt(6 / (inputs + outputs)) of each layer (Glorot & Bengio,
/// AISTATS 2010), and biases of 0.
numerics::FloatMlp untrained(std::size_t block, RandomStream& random) {
  const std::vector<int>& sizes = kShapes[block];
  Eigen::VectorXf parameters = Eigen::VectorXf::Zero(numerics::count_parameters(sizes));
  for (auto& layer : numerics::mlp_layers(sizes, parameters)) {
    const double bound =
        std::sqrt(6.0 / static_cast<double>(layer.weights.cols() + layer.weights.rows()));
    for (float& weight : layer.weights.reshaped()) {
      weight = static_cast<float>(random.uniform(-bound, bound));
    }
  }
  return {sizes, block == 2 ? numerics::Activation::sigmoid : numerics::Activation::relu,
          std::move(parameters)};
}

NetworkBlocks untrained(std::uint64_t seed) {
  RandomStream random(seed, "biotac-network");
  // In order: each draws after the one before it.
  return {untrained(std::size_t{0}, random), untrained(std::size_t{1}, random),
          untrained(std::size_t{2}, random), untrained(std::size_t{3}, random)};
}

/// Adds the gradient of the l1 norm of the hidden biases.
void add_bias_penalty(const numerics::FloatMlp& block, float weight, Eigen::VectorXf& gradient) {
  Eigen::VectorXf parameters = block.parameters();
  const auto layers = numerics::mlp_layers(block.sizes(), parameters);
  auto gradients = numerics::mlp_layers(block.sizes(), gradient);
  for (std::size_t k = 0; k + 1 < layers.size(); ++k) {
    gradients[k].biases += weight * layers[k].biases.array().sign().matrix();
  }
}

std::array<numerics::FloatAdam, 4> optimisers(const NetworkBlocks& blocks, double rate) {
  const auto adam = [&](std::size_t b) {
    return numerics::FloatAdam(blocks[b].parameters().size(), static_cast<float>(rate));
  };
  return {adam(0), adam(1), adam(2), adam(3)};
}

std::string layer_name(std::size_t block, std::size_t layer) {
  return fmt::format("mlp{}.{}", block + 1, layer + 1);
}

void check_inputs(const Eigen::MatrixXf& inputs) {
  if (inputs.rows() != kNetworkInputs) {
    throw BadInput(fmt::format("{} inputs, not {}", inputs.rows(), kNetworkInputs));
  }
  if (!inputs.allFinite()) throw BadInput("an input of the network is not finite");
}

Eigen::VectorXf spread(const Eigen::MatrixXf& values, const Eigen::VectorXf& mean) {
  const Eigen::MatrixXf deviations = values.colwise() - mean;
  return (deviations.rowwise().squaredNorm() / static_cast<float>(values.cols()))
      .cwiseSqrt()
      .cwiseMax(1e-12f);
}

Eigen::MatrixXf standardised(const Eigen::MatrixXf& values, const Eigen::VectorXf& mean,
                             const Eigen::VectorXf& sd) {
  return ((values.colwise() - mean).array().colwise() / sd.array()).matrix();
}

Eigen::MatrixXf columns_of(const Eigen::MatrixXf& values, const std::vector<Eigen::Index>& order,
                           std::size_t start, std::size_t end) {
  Eigen::MatrixXf batch(values.rows(), static_cast<Eigen::Index>(end - start));
  for (std::size_t k = start; k < end; ++k) {
    batch.col(static_cast<Eigen::Index>(k - start)) = values.col(order[k]);
  }
  return batch;
}

}  // namespace

BiotacNetwork::BiotacNetwork(std::uint64_t seed)
    : blocks_(untrained(seed)),
      input_mean_(Eigen::VectorXf::Zero(kNetworkInputs)),
      input_sd_(Eigen::VectorXf::Ones(kNetworkInputs)),
      output_mean_(Eigen::VectorXf::Zero(kNetworkOutputs)),
      output_sd_(Eigen::VectorXf::Ones(kNetworkOutputs)) {}

std::string BiotacNetwork::bytes() const {
  ArrayFile file(kNetworkKind, kNetworkVersion);
  file.add("input_mean", input_mean_);
  file.add("input_sd", input_sd_);
  file.add("output_mean", output_mean_);
  file.add("output_sd", output_sd_);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    Eigen::VectorXf parameters = blocks_[b].parameters();
    const auto layers = numerics::mlp_layers(blocks_[b].sizes(), parameters);
    for (std::size_t k = 0; k < layers.size(); ++k) {
      file.add(layer_name(b, k) + ".weights", layers[k].weights);
      file.add(layer_name(b, k) + ".biases", layers[k].biases);
    }
  }
  return file.bytes();
}

BiotacNetwork BiotacNetwork::parse(std::string_view bytes, const std::string& source) {
  const auto file = ArrayFile::parse(bytes, source, kNetworkKind, kNetworkVersion);
  BiotacNetwork network;
  network.input_mean_ = file.get("input_mean", kNetworkInputs, 1);
  network.input_sd_ = file.get("input_sd", kNetworkInputs, 1);
  network.output_mean_ = file.get("output_mean", kNetworkOutputs, 1);
  network.output_sd_ = file.get("output_sd", kNetworkOutputs, 1);
  if (network.input_sd_.minCoeff() <= 0 || network.output_sd_.minCoeff() <= 0) {
    throw BadInput(fmt::format("{}: a standard deviation is not positive", source));
  }
  for (std::size_t b = 0; b < network.blocks_.size(); ++b) {
    Eigen::VectorXf parameters = network.blocks_[b].parameters();
    auto layers = numerics::mlp_layers(network.blocks_[b].sizes(), parameters);
    for (std::size_t k = 0; k < layers.size(); ++k) {
      const Eigen::Index out = layers[k].weights.rows(), in = layers[k].weights.cols();
      layers[k].weights = file.get(layer_name(b, k) + ".weights", out, in);
      layers[k].biases = file.get(layer_name(b, k) + ".biases", out, 1);
    }
    network.blocks_[b].set_parameters(parameters);
  }
  return network;
}

Eigen::MatrixXf BiotacNetwork::operator()(const Eigen::MatrixXf& inputs) const {
  check_inputs(inputs);
  const auto trace = forward(blocks_, standardised(inputs, input_mean_, input_sd_));
  return ((trace.output.array().colwise() * output_sd_.array()).colwise() + output_mean_.array())
      .matrix();
}

double BiotacNetwork::train(const Eigen::MatrixXf& inputs, const Eigen::MatrixXf& outputs,
                            const NetworkTrainingOptions& options,
                            const ProgressCallback& progress) {
  check_inputs(inputs);
  if (outputs.rows() != kNetworkOutputs || outputs.cols() != inputs.cols() || inputs.cols() < 2 ||
      !outputs.allFinite()) {
    throw BadInput(fmt::format("{} x {} outputs for {} x {} inputs cannot be learned",
                               outputs.rows(), outputs.cols(), inputs.rows(), inputs.cols()));
  }
  input_mean_ = inputs.rowwise().mean();
  input_sd_ = spread(inputs, input_mean_);
  output_mean_ = outputs.rowwise().mean();
  output_sd_ = spread(outputs, output_mean_);
  const Eigen::MatrixXf x = standardised(inputs, input_mean_, input_sd_);
  const Eigen::MatrixXf y = standardised(outputs, output_mean_, output_sd_);
  RandomStream random(options.seed, "biotac-training");
  auto adams = optimisers(blocks_, options.rate);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(x.cols()));
  std::iota(order.begin(), order.end(), 0);
  double error = 0;
  for (int epoch = 0; epoch < options.epochs; ++epoch) {
    for (std::size_t i = order.size(); i > 1; --i) {
      std::swap(order[i - 1], order[random.index(i)]);
    }
    error = 0;
    for (std::size_t at = 0; at < order.size(); at += static_cast<std::size_t>(options.batch)) {
      const auto end = std::min(order.size(), at + static_cast<std::size_t>(options.batch));
      const double done =
          (epoch + static_cast<double>(at) / static_cast<double>(order.size())) / options.epochs;
      const double share = options.final_rate +
                           (1 - options.final_rate) * (1 + std::cos(std::numbers::pi * done)) / 2;
      const auto trace = forward(blocks_, columns_of(x, order, at, end));
      const Eigen::MatrixXf miss = trace.output - columns_of(y, order, at, end);
      error += miss.squaredNorm();
      const float scale = 2 / static_cast<float>(miss.size());
      auto gradient = backward(blocks_, trace, scale * miss);
      add_bias_penalty(blocks_[1], static_cast<float>(options.bias_penalty), gradient[1]);
      for (std::size_t b = 0; b < blocks_.size(); ++b) {
        adams[b].set_rate(static_cast<float>(options.rate * share));
        blocks_[b].set_parameters(adams[b].step(blocks_[b].parameters(), gradient[b]));
      }
    }
    if (progress) {
      progress(static_cast<std::size_t>(epoch + 1), static_cast<std::size_t>(options.epochs));
    }
  }
  return error / static_cast<double>(y.size());
}

Eigen::VectorXd error_ratios(const Eigen::MatrixXf& predicted, const Eigen::MatrixXf& truth) {
  const Eigen::VectorXf mean = truth.rowwise().mean();
  const Eigen::VectorXf mae = (predicted - truth).cwiseAbs().rowwise().mean();
  return (mae.array() / spread(truth, mean).array()).matrix().cast<double>();
}

Eigen::VectorXd shuffled_input_losses(const BiotacNetwork& network, const Eigen::MatrixXf& inputs,
                                      const Eigen::MatrixXf& outputs, std::uint64_t seed) {
  const double before = error_ratios(network(inputs), outputs).mean();
  RandomStream random(seed, "shuffle");
  Eigen::VectorXd losses(kNetworkInputs);
  for (int k = 0; k < kNetworkInputs; ++k) {
    Eigen::MatrixXf shuffled = inputs;
    for (Eigen::Index i = shuffled.cols(); i > 1; --i) {
      const auto other = static_cast<Eigen::Index>(random.index(static_cast<std::size_t>(i)));
      std::swap(shuffled(k, i - 1), shuffled(k, other));
    }
    losses[k] = error_ratios(network(shuffled), outputs).mean() - before;
  }
  return losses;
}

Eigen::VectorXd sensitivities(const BiotacNetwork& network, const Eigen::MatrixXf& inputs,
                              const Eigen::MatrixXf& outputs) {
  constexpr float kStep = 0.05f;  // standard deviations
  const Eigen::VectorXf sd_in = spread(inputs, inputs.rowwise().mean());
  const Eigen::VectorXf sd_out = spread(outputs, outputs.rowwise().mean());
  Eigen::VectorXd result(kNetworkInputs);
  for (int k = 0; k < kNetworkInputs; ++k) {
    Eigen::MatrixXf more = inputs, less = inputs;
    more.row(k).array() += kStep * sd_in[k];
    less.row(k).array() -= kStep * sd_in[k];
    const Eigen::MatrixXf change = (network(more) - network(less)).cwiseAbs();
    result[k] = (change.rowwise().mean().array() / sd_out.array()).mean() / (2 * kStep);
  }
  return result;
}

}  // namespace palpate::tactile
