// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <stop_token>
#include <thread>

namespace palpate::app {

/// Turns SIGINT, SIGTERM and, unless it is ignored (nohup), SIGHUP into a request to stop, while it
/// lives. A second signal ends the program at once. One at a time. Handled, not blocked: threads of
/// libraries that were started before (OpenMP's) would take a signal that is only blocked here.
class Interrupt {
 public:
  Interrupt() {
    received() = 0;
    struct sigaction action = {};
    action.sa_handler = [](int signal) {
      if (received().exchange(signal) == 0) return;
      std::signal(signal, SIG_DFL);
      std::raise(signal);
    };
    action.sa_flags = SA_RESTART;
    for (std::size_t i = 0; i < kSignals.size(); ++i) {
      sigaction(kSignals[i], &action, &before_[i]);
      if (kSignals[i] == SIGHUP && before_[i].sa_handler == SIG_IGN) restore(i);
    }
    thread_ = std::jthread([this](const std::stop_token& end) { wait(end); });
  }
  ~Interrupt() {
    thread_ = {};
    for (std::size_t i = 0; i < kSignals.size(); ++i) restore(i);
  }
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }

 private:
  static constexpr std::array<int, 3> kSignals = {SIGINT, SIGTERM, SIGHUP};

  void restore(std::size_t i) const { sigaction(kSignals[i], &before_[i], nullptr); }

  static std::atomic<int>& received() {
    static std::atomic<int> signal = 0;
    return signal;
  }

  void wait(const std::stop_token& end) {
    while (!end.stop_requested()) {
      if (received() != 0) source_.request_stop();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  std::array<struct sigaction, kSignals.size()> before_ = {};
  std::stop_source source_;
  std::jthread thread_;
};

}  // namespace palpate::app
