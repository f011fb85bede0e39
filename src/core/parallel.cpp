// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/parallel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>

#include "palpate/core/error.hpp"

namespace palpate {
namespace {

/// The exception of the lowest index.
class FirstFailure {
 public:
  void note(std::size_t index, std::exception_ptr failure) {
    const std::lock_guard lock(mutex_);
    if (!failure_ || index < index_) {
      index_ = index;
      failure_ = std::move(failure);
    }
  }
  bool any() {
    const std::lock_guard lock(mutex_);
    return failure_ != nullptr;
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::mutex mutex_;
  std::size_t index_ = 0;
  std::exception_ptr failure_;
};

}  // namespace

void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& work) {
  if (threads < 1) throw BadInput(fmt::format("{} threads: at least 1 is needed", threads));
  std::atomic<std::size_t> next = 0;
  FirstFailure failure;
  const auto take_turns = [&] {
    for (std::size_t index; !failure.any() && (index = next++) < count;) {
      try {
        work(index);
      } catch (...) {
        failure.note(index, std::current_exception());
      }
    }
  };
  {
    std::vector<std::jthread> others;  // joined at the brace, even if one cannot be started
    const std::size_t used = std::min(count, static_cast<std::size_t>(threads));
    for (std::size_t i = 1; i < used; ++i) others.emplace_back(take_turns);
    take_turns();
  }
  failure.rethrow();
}

}  // namespace palpate
