// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

namespace palpate::skills {

/// Stops the drives of a hand whose step takes too long by the steady clock.
class Watchdog {
 public:
  /// @param stop_drives  called from the watchdog's thread; may be empty, and may throw
  /// @param limit  s that a step may take
  Watchdog(std::function<void()> stop_drives, double limit);

  /// Whether it has ever done so.
  [[nodiscard]] bool fired() const { return fired_; }

  /// A step is under way while this lives; without a watchdog it does nothing.
  class Guard {
   public:
    explicit Guard(Watchdog* watchdog) : watchdog_(watchdog) {
      if (watchdog_) watchdog_->begin();
    }
    ~Guard() {
      if (watchdog_) watchdog_->end();
    }
    Guard(const Guard&) = delete;
    Guard& operator=(const Guard&) = delete;

   private:
    Watchdog* watchdog_;
  };

 private:
  using Clock = std::chrono::steady_clock;

  void begin();
  void end();
  void watch(const std::stop_token& ended);
  void stop();

  std::function<void()> stop_drives_;
  Clock::duration limit_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Clock::time_point> deadline_;  // of the step that is under way
  std::atomic<bool> fired_ = false;
  std::jthread thread_;  // last, so that it ends first
};

}  // namespace palpate::skills
