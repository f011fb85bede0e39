// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "palpate/core/parallel.hpp"

namespace palpate::geometry {

/// Calls work(0) .. work(count - 1), each once, in blocks of neighbouring points on up to `threads`
/// threads.
template <class Work>
void parallel_blocks(std::size_t count, int threads, const Work& work) {
  constexpr std::size_t kBlock = 256;
  parallel_for((count + kBlock - 1) / kBlock, threads, [&](std::size_t block) {
    const std::size_t end = std::min(count, (block + 1) * kBlock);
    for (std::size_t i = block * kBlock; i < end; ++i) work(i);
  });
}

}  // namespace palpate::geometry
