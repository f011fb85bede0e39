// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "palpate/tactile/biotac/network.hpp"

namespace palpate::tactile {

/// What the four blocks computed on a batch of standardised inputs.
struct NetworkTrace {
  std::array<numerics::FloatMlp::Trace, 4> blocks;
  Eigen::MatrixXf output;  // 23 x n, standardised
};

NetworkTrace forward(const NetworkBlocks& blocks, const Eigen::MatrixXf& inputs);

/// Gradients by the parameters of each block, of a loss with the given gradient by the output.
std::array<Eigen::VectorXf, 4> backward(const NetworkBlocks& blocks, const NetworkTrace& trace,
                                        const Eigen::MatrixXf& output);

}  // namespace palpate::tactile
