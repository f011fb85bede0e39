// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "palpate/tasks/relocate/training/trainer.hpp"

namespace palpate::app {

/// The learning curves so far: a row an iteration.
class Curves {
 public:
  explicit Curves(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void add(const relocate::Metrics& metrics);
  const Eigen::MatrixXd& values() const { return values_; }
  void restore(const Eigen::MatrixXd& values) { values_ = values; }
  /// As curves.csv, and a figure of each.
  void write() const;

 private:
  void write_figure(std::size_t k) const;

  std::filesystem::path folder_;
  std::vector<std::string> names_;
  Eigen::MatrixXd values_;
};

}  // namespace palpate::app
