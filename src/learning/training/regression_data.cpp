// SPDX-License-Identifier: Apache-2.0
#include "learning/training/regression_data.hpp"

namespace palpate::learning {

RegressionData joined(const std::vector<RegressionData>& parts) {
  RegressionData all;
  Eigen::Index count = 0;
  for (const auto& part : parts) count += part.inputs.cols();
  Eigen::Index next = 0;
  for (const auto& part : parts) {
    if (part.inputs.cols() == 0) continue;
    if (next == 0) {
      all.inputs.resize(part.inputs.rows(), count);
      all.targets.resize(part.targets.rows(), count);
    }
    all.inputs.middleCols(next, part.inputs.cols()) = part.inputs;
    all.targets.middleCols(next, part.inputs.cols()) = part.targets;
    next += part.inputs.cols();
  }
  return all;
}

std::pair<Eigen::VectorXd, Eigen::VectorXd> standardization(const Eigen::MatrixXd& inputs,
                                                            double least) {
  const Eigen::VectorXd center = inputs.rowwise().mean();
  const Eigen::VectorXd spread =
      (inputs.colwise() - center).array().square().rowwise().mean().sqrt();
  return {center, spread.cwiseMax(least)};
}

}  // namespace palpate::learning
