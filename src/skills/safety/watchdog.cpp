// SPDX-License-Identifier: Apache-2.0
#include "skills/safety/watchdog.hpp"

#include <utility>

namespace palpate::skills {

Watchdog::Watchdog(std::function<void()> stop_drives, double limit)
    : stop_drives_(std::move(stop_drives)),
      limit_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limit))),
      thread_([this](const std::stop_token& ended) { watch(ended); }) {}

void Watchdog::begin() {
  const std::lock_guard lock(mutex_);
  deadline_ = Clock::now() + limit_;
  changed_.notify_one();
}

void Watchdog::end() {
  const std::lock_guard lock(mutex_);
  deadline_.reset();
}

/// Whatever is thrown, the executor says that the hand was silent, and eases what still moves.
void Watchdog::stop() {
  try {
    if (stop_drives_) stop_drives_();
  } catch (...) {
  }
}

void Watchdog::watch(const std::stop_token& ended) {
  std::unique_lock lock(mutex_);
  while (!ended.stop_requested()) {
    if (!deadline_) {
      changed_.wait(lock, ended, [this] { return deadline_.has_value(); });
    } else if (const auto deadline = *deadline_; Clock::now() < deadline) {
      changed_.wait_until(lock, ended, deadline, [&] { return deadline_ != deadline; });
    } else {
      deadline_.reset();
      fired_ = true;
      lock.unlock();
      stop();
      lock.lock();
    }
  }
}

}  // namespace palpate::skills
