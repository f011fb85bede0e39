// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace palpate {

/// Threads that stay between calls, for short work that comes again and again: parallel_for()
/// starts its threads again, which takes longer than a step of physics may.
///
/// A thread without work looks for it for some tenths of a millisecond before it sleeps, for waking
/// takes as long. One call at a time. In a process that was forked from the one that made the pool
/// everything runs in the caller's thread.
class WorkerPool {
 public:
  /// @param threads  with the caller's own
  /// @throws BadInput for less than one thread
  explicit WorkerPool(int threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  [[nodiscard]] int threads() const { return threads_; }

  /// Calls work(0) .. work(count - 1), each once; the lower an index, the earlier it is begun.
  /// Of the exceptions that calls throw, one is thrown again once all have ended; no new calls
  /// start after it.
  void run(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  struct Shared;
  void stop();

  int threads_;
  int process_;
  std::unique_ptr<Shared> shared_;
};

}  // namespace palpate
