// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

// A second version for processors with wider registers, chosen when the program starts; the
// results are the same. Sanitizers start too late for that.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define PALPATE_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define PALPATE_WIDE
#endif

namespace palpate::registration {

inline constexpr int kWordBits = 64;

/// Calls visit(bit) for every bit that is set, lowest first.
template <class Visit>
void for_each_bit(const std::uint64_t* words, int count, const Visit& visit) {
  for (int w = 0; w < count; ++w) {
    for (std::uint64_t rest = words[w]; rest != 0; rest &= rest - 1) {
      visit(w * kWordBits + std::countr_zero(rest));
    }
  }
}

/// Adds to `clique` the candidate that keeps most of the candidates as neighbours, and drops those
/// that it does not keep, until none is left or the clique has max_size vertices.
/// @param rows  of the graph, `words` words each
/// @param candidates  vertices joined with all of the clique; used up
void extend_clique(const std::uint64_t* rows, int words, std::vector<std::uint64_t>& candidates,
                   int max_size, std::vector<int>& clique);

}  // namespace palpate::registration
