// SPDX-License-Identifier: Apache-2.0
#include "consistency_graph.hpp"

#include <fmt/format.h>

#include "palpate/core/error.hpp"
#include "registration/bitset_rows.hpp"
#include "registration/pair_gates.hpp"

namespace palpate::registration {

ConsistencyGraph::ConsistencyGraph(const Correspondences& correspondences,
                                   const ConsistencyOptions& options) {
  check(correspondences);
  const double unit = options.noise_bound;
  if (!(unit > 0) || !(options.length_tolerance > 0)) {
    throw BadInput(fmt::format("noise bound {} m with tolerance {} is not positive", unit,
                               options.length_tolerance));
  }
  size_ = static_cast<int>(correspondences.size());
  words_ = (size_ + kWordBits - 1) / kWordBits;
  bits_.assign(static_cast<std::size_t>(size_) * static_cast<std::size_t>(words_), 0);
  degrees_.assign(correspondences.size(), 0);
  if (size_ == 0) return;
  const bool angles = options.normal_noise_deg > 0 && correspondences.has_normals();
  const PairColumns columns = columns_of(correspondences, correspondences.source[0],
                                         correspondences.target[0], unit, angles);
  PairGates gates(columns, options.length_tolerance, angles ? options.normal_noise_deg : 0);
  for (int i = 0; i < size_; ++i) {
    std::uint64_t* bits = bits_.data() + std::ptrdiff_t{i} * words_;
    gates.row(i, bits);
    for_each_bit(bits, words_, [&](int) { ++degrees_[static_cast<std::size_t>(i)]; });
  }
}

double ConsistencyGraph::density() const {
  if (size_ < 2) return 0;
  double sum = 0;
  for (const int degree : degrees_) sum += degree;
  return sum / (static_cast<double>(size_) * (size_ - 1));
}

std::vector<int> grow_clique(const ConsistencyGraph& graph, int seed, int max_size) {
  std::vector<std::uint64_t> candidates(graph.row(seed), graph.row(seed) + graph.words());
  std::vector<int> clique{seed};
  extend_clique(graph.row(0), graph.words(), candidates, max_size, clique);
  return clique;
}

}  // namespace palpate::registration
