// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "palpate/core/parallel.hpp"

namespace palpate::geometry {

/// Calls work(first, end) for blocks of neighbouring points that make up 0 .. count - 1, on up to
/// `threads` threads.
template <class Work>
void parallel_ranges(std::size_t count, int threads, const Work& work) {
  constexpr std::size_t kBlock = 256;
  parallel_for((count + kBlock - 1) / kBlock, threads, [&](std::size_t block) {
    work(block * kBlock, std::min(count, (block + 1) * kBlock));
  });
}

/// Calls work(0) .. work(count - 1), each once, in such blocks.
template <class Work>
void parallel_blocks(std::size_t count, int threads, const Work& work) {
  parallel_ranges(count, threads, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) work(i);
  });
}

}  // namespace palpate::geometry
