// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/progress.hpp"
#include "palpate/numerics/mlp.hpp"
#include "palpate/tactile/biotac/dataset.hpp"

namespace palpate::tactile {

/// MLP 1 position, 2 forces, 3 temperature, 4 combination.
using NetworkBlocks = std::array<numerics::FloatMlp, 4>;

struct NetworkTrainingOptions {
  int epochs = 12;
  int batch = 64;
  double rate = 1e-3;          ///< of Adam, at the start
  double final_rate = 0.02;    ///< share of it left at the end; in between as a cosine
  double bias_penalty = 1e-5;  ///< weight of the l1 norm of MLP 2's hidden biases
  std::uint64_t seed = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("epochs", epochs, 1, 10000, "number of passes over the data set");
    v("batch", batch, 1, 100000, "number of rows per training step");
    v("rate", rate, 1e-7, 1.0, "initial learning rate of Adam");
    v("final_rate", final_rate, 0.0, 1.0, "final learning rate relative to the initial one");
    v("bias_penalty", bias_penalty, 0.0, 1.0,
      "weight of the L1 norm of the hidden biases of MLP 2");
  }
};

/// Architecture B (thesis section 5.1.2, fig. 5.1; Ruppel et al. 2019): 13 -> 23.
///
/// MLP 1 (position) 3-512-512-512-64 and MLP 2 (forces) 9-256-256-256-64, ReLU and a linear end;
/// their product through MLP 4, 64-256-256-23, ReLU and a linear end; plus MLP 3 (temperature),
/// 1-256-23, sigmoid and a linear end. Inputs and outputs are standardised.
class BiotacNetwork {
 public:
  /// Untrained, Glorot-uniform weights.
  explicit BiotacNetwork(std::uint64_t seed = 0);

  /// @throws BadInput, naming the source, for another version or shape, a truncated file, or a
  ///         value that is not finite
  static BiotacNetwork parse(std::string_view bytes, const std::string& source);
  [[nodiscard]] std::string bytes() const;

  /// Counts (23 x n) that a BioTac would show. @param inputs  13 x n, as network_inputs gives them
  /// @throws BadInput for another height or values that are not finite
  [[nodiscard]] Eigen::MatrixXf operator()(const Eigen::MatrixXf& inputs) const;

  /// Fits all weights by Adam to the mean squared standardised error.
  /// @return mean squared standardised error of the last epoch
  /// @throws BadInput for sizes that differ, too few columns, or values that are not finite
  double train(const Eigen::MatrixXf& inputs, const Eigen::MatrixXf& outputs,
               const NetworkTrainingOptions& options = {}, const ProgressCallback& progress = {});

  [[nodiscard]] const NetworkBlocks& blocks() const { return blocks_; }

 private:
  NetworkBlocks blocks_;
  Eigen::VectorXf input_mean_, input_sd_, output_mean_, output_sd_;
};

/// Mean absolute error of each channel over its standard deviation in `truth` (both 23 x n).
Eigen::VectorXd error_ratios(const Eigen::MatrixXf& predicted, const Eigen::MatrixXf& truth);

/// How much the error ratio (mean of the channels) grows when one input is shuffled among the
/// samples; 13 values.
Eigen::VectorXd shuffled_input_losses(const BiotacNetwork& network, const Eigen::MatrixXf& inputs,
                                      const Eigen::MatrixXf& outputs, std::uint64_t seed);

/// Mean over channels of |d output / d input| in standard deviations of both; 13 values.
Eigen::VectorXd sensitivities(const BiotacNetwork& network, const Eigen::MatrixXf& inputs,
                              const Eigen::MatrixXf& outputs);

}  // namespace palpate::tactile
