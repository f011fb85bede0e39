// SPDX-License-Identifier: Apache-2.0
#include "train_curves.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "palpate/core/file.hpp"
#include "palpate/plotting/plot.hpp"

namespace palpate::app {

void Curves::add(const relocate::Metrics& metrics) {
  const Eigen::Index row = values_.rows();
  values_.conservativeResize(row + 1, std::ssize(metrics));
  for (Eigen::Index k = 0; k < values_.cols(); ++k) {
    values_(row, k) = metrics[static_cast<std::size_t>(k)].second;
  }
  names_.clear();
  for (const auto& [name, value] : metrics) names_.push_back(name);
}

void Curves::write() const {
  std::string csv = fmt::format("iteration,{}\n", fmt::join(names_, ","));
  for (Eigen::Index i = 0; i < values_.rows(); ++i) {
    csv += fmt::format("{}", i);
    for (const double value : values_.row(i)) csv += fmt::format(",{}", value);
    csv += "\n";
  }
  write_file_atomically(folder_ / "curves.csv", csv);
  for (std::size_t k = 0; k < names_.size(); ++k) write_figure(k);
}

void Curves::write_figure(std::size_t k) const {
  plotting::Plot plot;
  plot.title = names_[k];
  plot.x.label = "iteration";
  plot.y.label = names_[k];
  plotting::LineSeries line;
  for (Eigen::Index i = 0; i < values_.rows(); ++i) {
    line.x.push_back(static_cast<double>(i));
    line.y.push_back(values_(i, static_cast<Eigen::Index>(k)));
  }
  plot.series.emplace_back(line);
  write_file_atomically(folder_ / (names_[k] + ".svg"), plotting::to_svg(plot));
}

}  // namespace palpate::app
