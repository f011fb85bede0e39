// SPDX-License-Identifier: Apache-2.0
#include "registration/ego_graph.hpp"

#include <algorithm>

#include "registration/bitset_rows.hpp"

namespace palpate::registration {

void EgoGraph::look_around(int center) {
  center_ = center;
  row_.resize(static_cast<std::size_t>(all_.words()));
  all_.row(center, row_.data());
  neighbours_.clear();
  for_each_bit(row_.data(), all_.words(), [&](int j) { neighbours_.push_back(j); });
  gather(columns_, neighbours_, local_);
  words_ = near_.words();
  rows_.assign(neighbours_.size() * static_cast<std::size_t>(words_), 0);
  for (int i = 0; i < near_.size(); ++i) near_.row(i, rows_.data() + std::ptrdiff_t{i} * words_);
}

std::vector<int> EgoGraph::clique(int max_size) {
  const auto count = neighbours_.size();
  candidates_.assign(static_cast<std::size_t>(words_), ~std::uint64_t{0});
  if (count % kWordBits != 0) candidates_.back() = (std::uint64_t{1} << (count % kWordBits)) - 1;
  std::vector<int> clique;
  extend_clique(rows_.data(), words_, candidates_, max_size - 1, clique);
  for (int& vertex : clique) vertex = neighbours_[static_cast<std::size_t>(vertex)];
  clique.insert(clique.begin(), center_);
  return clique;
}

}  // namespace palpate::registration
