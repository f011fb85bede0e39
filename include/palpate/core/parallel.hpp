// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace palpate {

/// Calls work(0) .. work(count - 1), each once, on up to `threads` threads.
///
/// With one thread everything runs in the caller's, in order. Of the exceptions that calls throw,
/// that of the lowest index is thrown again once all threads have stopped; no new calls start after
/// a failure.
/// @throws BadInput for less than one thread
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

/// Produces results on several threads and consumes them one by one in the order of their indices.
///
/// @param produce  index -> result; on any thread
/// @param consume  (index, result); never two at a time, index 0 first; not called again once it
///                 has thrown, nor beyond the first index whose result could not be produced
template <class Produce, class Consume>
void parallel_ordered(std::size_t count, int threads, const Produce& produce,
                      const Consume& consume) {
  using Result = decltype(produce(std::size_t{}));
  std::vector<std::optional<Result>> waiting(count);
  std::mutex mutex;
  std::size_t next = 0;
  parallel_for(count, threads, [&](std::size_t index) {
    Result result = produce(index);
    const std::lock_guard lock(mutex);
    waiting[index] = std::move(result);
    while (next < count && waiting[next]) {
      const std::size_t current = std::exchange(next, count);  // nobody goes on if consume throws
      consume(current, *waiting[current]);
      waiting[current].reset();
      next = current + 1;
    }
  });
}

}  // namespace palpate
