// SPDX-License-Identifier: Apache-2.0
#include "tactile/biotac/backpropagation.hpp"

#include <cmath>

namespace palpate::tactile {
namespace {

constexpr float kFirstDecay = 0.9f, kSecondDecay = 0.999f, kEpsilon = 1e-8f;

BlockTrace run(const NetworkBlock& block, Eigen::MatrixXf inputs) {
  BlockTrace trace = {std::move(inputs)};
  for (const NetworkLayer& layer : block) {
    Eigen::MatrixXf values = layer.weights * trace.back();
    values.colwise() += layer.biases;
    if (layer.activation == LayerActivation::relu) values = values.cwiseMax(0.0f);
    if (layer.activation == LayerActivation::sigmoid) {
      values = (1 / (1 + (-values.array()).exp())).matrix();
    }
    trace.push_back(std::move(values));
  }
  return trace;
}

/// Gradient of a block's layers; `outward` becomes the gradient by the block's inputs.
NetworkBlock run_back(const NetworkBlock& block, const BlockTrace& trace,
                      Eigen::MatrixXf& outward) {
  NetworkBlock gradient(block.size());
  for (std::size_t k = block.size(); k-- > 0;) {
    const auto values = trace[k + 1].array();
    if (block[k].activation == LayerActivation::relu) {
      outward = (values > 0).select(outward.array(), 0.0f).matrix();
    } else if (block[k].activation == LayerActivation::sigmoid) {
      outward = (outward.array() * values * (1 - values)).matrix();
    }
    gradient[k].weights = outward * trace[k].transpose();
    gradient[k].biases = outward.rowwise().sum();
    if (k > 0 || trace[0].rows() == 64) outward = block[k].weights.transpose() * outward;
  }
  return gradient;
}

template <class Values>
void adapt(Values& values, const Values& gradient, Values& first, Values& second, float rate,
           float first_share, float second_share) {
  first = kFirstDecay * first + (1 - kFirstDecay) * gradient;
  second.array() = kSecondDecay * second.array() + (1 - kSecondDecay) * gradient.array().square();
  values.array() -=
      rate * (first.array() / first_share) / ((second.array() / second_share).sqrt() + kEpsilon);
}

}  // namespace

NetworkTrace forward(const std::array<NetworkBlock, 4>& blocks, const Eigen::MatrixXf& inputs) {
  NetworkTrace trace;
  trace.blocks[0] = run(blocks[0], inputs.topRows<3>());
  trace.blocks[1] = run(blocks[1], inputs.middleRows<9>(3));
  trace.blocks[2] = run(blocks[2], inputs.bottomRows<1>());
  trace.blocks[3] = run(blocks[3], trace.blocks[0].back().cwiseProduct(trace.blocks[1].back()));
  trace.output = trace.blocks[3].back() + trace.blocks[2].back();
  return trace;
}

std::array<NetworkBlock, 4> backward(const std::array<NetworkBlock, 4>& blocks,
                                     const NetworkTrace& trace, const Eigen::MatrixXf& output) {
  std::array<NetworkBlock, 4> gradient;
  Eigen::MatrixXf product = output, temperature = output;
  gradient[2] = run_back(blocks[2], trace.blocks[2], temperature);
  gradient[3] = run_back(blocks[3], trace.blocks[3], product);
  Eigen::MatrixXf position = product.cwiseProduct(trace.blocks[1].back());
  Eigen::MatrixXf forces = product.cwiseProduct(trace.blocks[0].back());
  gradient[0] = run_back(blocks[0], trace.blocks[0], position);
  gradient[1] = run_back(blocks[1], trace.blocks[1], forces);
  return gradient;
}

BlockAdam::BlockAdam(const std::array<NetworkBlock, 4>& blocks) : first_(blocks), second_(blocks) {
  for (auto* moments : {&first_, &second_}) {
    for (auto& block : *moments) {
      for (auto& layer : block) {
        layer.weights.setZero();
        layer.biases.setZero();
      }
    }
  }
}

void BlockAdam::step(std::array<NetworkBlock, 4>& blocks,
                     const std::array<NetworkBlock, 4>& gradient, float rate) {
  decayed_first_ *= kFirstDecay;
  decayed_second_ *= kSecondDecay;
  const float first_share = 1 - decayed_first_, second_share = 1 - decayed_second_;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (std::size_t k = 0; k < blocks[b].size(); ++k) {
      adapt(blocks[b][k].weights, gradient[b][k].weights, first_[b][k].weights,
            second_[b][k].weights, rate, first_share, second_share);
      adapt(blocks[b][k].biases, gradient[b][k].biases, first_[b][k].biases, second_[b][k].biases,
            rate, first_share, second_share);
    }
  }
}

}  // namespace palpate::tactile
