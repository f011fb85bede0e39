// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>
#include <ctime>
#include <stop_token>
#include <thread>

namespace palpate::app {

/// Turns SIGINT and SIGTERM into a request to stop, while it lives. To be made before the threads
/// that are to run undisturbed. A second signal ends the program at once.
class Interrupt {
 public:
  Interrupt() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, &before_);
    thread_ = std::jthread([this](const std::stop_token& end) { wait(end); });
  }
  ~Interrupt() {
    thread_ = {};
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }

 private:
  void wait(const std::stop_token& end) {
    constexpr timespec kPoll = {0, 100'000'000};
    while (!end.stop_requested()) {
      const int signal = sigtimedwait(&signals_, nullptr, &kPoll);
      if (signal < 0 || source_.request_stop()) continue;
      pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
      raise(signal);
    }
  }

  sigset_t signals_{}, before_{};
  std::stop_source source_;
  std::jthread thread_;
};

}  // namespace palpate::app
