// SPDX-License-Identifier: Apache-2.0
#include "registration/bitset_rows.hpp"

#include <cstddef>

namespace palpate::registration {
namespace {

struct Keeping {
  int vertex = -1, neighbours = -1;
};

/// The candidate with most neighbours among the candidates, the first of equals.
PALPATE_WIDE Keeping best_candidate(const std::uint64_t* rows, int words,
                                    const std::uint64_t* candidates) {
  Keeping best;
  for (int w = 0; w < words; ++w) {
    for (std::uint64_t rest = candidates[w]; rest != 0; rest &= rest - 1) {
      const int vertex = w * kWordBits + std::countr_zero(rest);
      const std::uint64_t* row = rows + std::ptrdiff_t{vertex} * words;
      int common = 0;
      for (int k = 0; k < words; ++k) common += std::popcount(row[k] & candidates[k]);
      if (common > best.neighbours) best = {vertex, common};
    }
  }
  return best;
}

}  // namespace

void extend_clique(const std::uint64_t* rows, int words, std::vector<std::uint64_t>& candidates,
                   int max_size, std::vector<int>& clique) {
  while (static_cast<int>(clique.size()) < max_size) {
    const Keeping best = best_candidate(rows, words, candidates.data());
    if (best.vertex < 0) return;
    clique.push_back(best.vertex);
    const std::uint64_t* row = rows + std::ptrdiff_t{best.vertex} * words;
    for (int w = 0; w < words; ++w) candidates[static_cast<std::size_t>(w)] &= row[w];
  }
}

}  // namespace palpate::registration
