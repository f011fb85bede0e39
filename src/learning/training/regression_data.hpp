// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace palpate::learning {

/// What to learn from: one example a column.
struct RegressionData {
  Eigen::MatrixXd inputs, targets;
};

/// All examples, in their order; parts without any are skipped.
RegressionData joined(const std::vector<RegressionData>& parts);

/// Mean and standard deviation of each row, the latter no less than `least`.
std::pair<Eigen::VectorXd, Eigen::VectorXd> standardization(const Eigen::MatrixXd& inputs,
                                                            double least);

}  // namespace palpate::learning
