// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/worker_pool.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "palpate/core/error.hpp"

namespace palpate {
namespace {

constexpr std::chrono::microseconds kPatience{300};  // of looking before sleeping
constexpr int kLooks = 64;                           // between two looks at the clock

void pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

/// Until the value is another than `old`: by looking, then asleep.
template <class Value>
void await_change(const std::atomic<Value>& value, Value old) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  do {
    for (int i = 0; i < kLooks; ++i) {
      if (value.load(std::memory_order_acquire) != old) return;
      pause();
    }
  } while (std::chrono::steady_clock::now() < end);
  value.wait(old, std::memory_order_acquire);
}

}  // namespace

/// What the threads look at. A thread that comes late to a call finds it closed and is not waited
/// for: it says that it is at work before it looks, and a call ends only when nobody is.
struct WorkerPool::Shared {
  std::atomic<unsigned> call = 0;  ///< counts calls of run()
  std::atomic<bool> open = false;  ///< the call has work left
  std::atomic<int> at_work = 0;    ///< threads that may be in it
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false, over = false;
  std::size_t count = 0;
  const std::function<void(std::size_t)>* work = nullptr;
  std::mutex mutex;  ///< of the failure
  std::exception_ptr failure;
  std::vector<std::thread> threads;

  void take_turns() {
    for (std::size_t index; !failed && (index = next++) < count;) {
      try {
        (*work)(index);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        failed = true;
      }
    }
  }

  void serve() {
    for (unsigned seen = 0;;) {
      await_change(call, seen);
      seen = call;  // a call that begins from here on is seen in the next round
      if (over) return;
      ++at_work;
      if (open) take_turns();
      if (--at_work == 0) at_work.notify_one();
    }
  }
};

WorkerPool::WorkerPool(int threads)
    : threads_(threads), process_(getpid()), shared_(std::make_unique<Shared>()) {
  if (threads < 1) throw BadInput(fmt::format("{} threads: at least 1 is needed", threads));
  try {
    for (int i = 1; i < threads; ++i) {
      shared_->threads.emplace_back([shared = shared_.get()] { shared->serve(); });
    }
  } catch (...) {
    stop();
    throw;
  }
}

WorkerPool::~WorkerPool() {
  if (getpid() == process_) {
    stop();
  } else {
    shared_.release();  // NOLINT(bugprone-unused-return-value): its threads are not of this process
  }
}

void WorkerPool::stop() {
  shared_->over = true;
  ++shared_->call;
  shared_->call.notify_all();
  for (std::thread& thread : shared_->threads) thread.join();
}

void WorkerPool::run(std::size_t count, const std::function<void(std::size_t)>& work) {
  Shared& all = *shared_;
  if (all.threads.empty() || count < 2 || getpid() != process_) {
    for (std::size_t i = 0; i < count; ++i) work(i);
    return;
  }
  all.count = count, all.work = &work;
  all.next = 0, all.failed = false, all.failure = nullptr;
  all.open = true;
  ++all.call;
  all.call.notify_all();
  all.take_turns();
  all.open = false;
  for (int busy; (busy = all.at_work) > 0;) await_change(all.at_work, busy);
  if (all.failure) std::rethrow_exception(all.failure);
}

}  // namespace palpate
