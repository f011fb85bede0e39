// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "palpate/tactile/biotac/network.hpp"

namespace palpate::tactile {

/// Outputs of all layers of a block, its inputs first.
using BlockTrace = std::vector<Eigen::MatrixXf>;

/// What the four blocks computed on a batch of standardised inputs.
struct NetworkTrace {
  std::array<BlockTrace, 4> blocks;
  Eigen::MatrixXf output;  // 23 x n, standardised
};

NetworkTrace forward(const std::array<NetworkBlock, 4>& blocks, const Eigen::MatrixXf& inputs);

/// Gradients in the layout of the layers, of a loss with the given gradient by the output.
std::array<NetworkBlock, 4> backward(const std::array<NetworkBlock, 4>& blocks,
                                     const NetworkTrace& trace, const Eigen::MatrixXf& output);

/// Adam (Kingma & Ba 2015) over all layers.
class BlockAdam {
 public:
  explicit BlockAdam(const std::array<NetworkBlock, 4>& blocks);
  void step(std::array<NetworkBlock, 4>& blocks, const std::array<NetworkBlock, 4>& gradient,
            float rate);

 private:
  std::array<NetworkBlock, 4> first_, second_;  // moments
  float decayed_first_ = 1, decayed_second_ = 1;
};

}  // namespace palpate::tactile
