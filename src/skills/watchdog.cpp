// SPDX-License-Identifier: Apache-2.0
#include "skills/watchdog.hpp"

#include <utility>

namespace palpate::skills {

Watchdog::Watchdog(std::function<void()> stop_drives, double limit)
    : stop_drives_(std::move(stop_drives)),
      limit_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limit))),
      thread_([this](const std::stop_token& stop) { watch(stop); }) {}

void Watchdog::begin() {
  const std::lock_guard lock(mutex_);
  deadline_ = Clock::now() + limit_;
  changed_.notify_one();
}

void Watchdog::end() {
  const std::lock_guard lock(mutex_);
  deadline_.reset();
}

void Watchdog::watch(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (!deadline_) {
      changed_.wait(lock, stop, [this] { return deadline_.has_value(); });
    } else if (const auto deadline = *deadline_; Clock::now() < deadline) {
      changed_.wait_until(lock, stop, deadline, [&] { return deadline_ != deadline; });
    } else {
      deadline_.reset();
      fired_ = true;
      if (stop_drives_) stop_drives_();
    }
  }
}

}  // namespace palpate::skills
