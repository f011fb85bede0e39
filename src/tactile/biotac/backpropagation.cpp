// SPDX-License-Identifier: Apache-2.0
#include "tactile/biotac/backpropagation.hpp"

namespace palpate::tactile {

NetworkTrace forward(const NetworkBlocks& blocks, const Eigen::MatrixXf& inputs) {
  NetworkTrace trace;
  trace.blocks[0] = blocks[0].trace(inputs.topRows<3>());
  trace.blocks[1] = blocks[1].trace(inputs.middleRows<9>(3));
  trace.blocks[2] = blocks[2].trace(inputs.bottomRows<1>());
  trace.blocks[3] = blocks[3].trace(trace.blocks[0].back().cwiseProduct(trace.blocks[1].back()));
  trace.output = trace.blocks[3].back() + trace.blocks[2].back();
  return trace;
}

std::array<Eigen::VectorXf, 4> backward(const NetworkBlocks& blocks, const NetworkTrace& trace,
                                        const Eigen::MatrixXf& output) {
  std::array<Eigen::VectorXf, 4> gradient;
  Eigen::MatrixXf product;
  gradient[2] = blocks[2].gradient(trace.blocks[2], output);
  gradient[3] = blocks[3].gradient(trace.blocks[3], output, &product);
  gradient[0] = blocks[0].gradient(trace.blocks[0], product.cwiseProduct(trace.blocks[1].back()));
  gradient[1] = blocks[1].gradient(trace.blocks[1], product.cwiseProduct(trace.blocks[0].back()));
  return gradient;
}

}  // namespace palpate::tactile
