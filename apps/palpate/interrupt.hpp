// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <csignal>
#include <stop_token>
#include <thread>

namespace palpate::app {

/// Turns SIGINT and SIGTERM into a request to stop, while it lives. A second signal ends the
/// program at once. One at a time. Handled, not blocked: threads of libraries that were started
/// before (OpenMP's) would take a signal that is only blocked here.
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
    sigaction(SIGINT, &action, &before_[0]);
    sigaction(SIGTERM, &action, &before_[1]);
    thread_ = std::jthread([this](const std::stop_token& end) { wait(end); });
  }
  ~Interrupt() {
    thread_ = {};
    sigaction(SIGINT, &before_[0], nullptr);
    sigaction(SIGTERM, &before_[1], nullptr);
  }
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }

 private:
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

  struct sigaction before_[2] = {};
  std::stop_source source_;
  std::jthread thread_;
};

}  // namespace palpate::app
