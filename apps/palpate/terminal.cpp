// SPDX-License-Identifier: Apache-2.0
#include "terminal.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <utility>

namespace palpate::app {
namespace {

constexpr int kUnannounced = 2;  // s that need no clock

bool has_colors() {
  const char* const refused = std::getenv("NO_COLOR");
  const char* const terminal = std::getenv("TERM");
  const bool dumb = terminal && std::string_view(terminal) == "dumb";
  return isatty(STDOUT_FILENO) != 0 && !dumb && !(refused && *refused);
}

int color_of(std::string_view status) {
  constexpr int kRed = 31, kGreen = 32, kYellow = 33;
  constexpr std::array kGood = {"ok", "certain", "found", "certified"};
  if (std::ranges::find(kGood, status) != kGood.end()) return kGreen;
  return status == "ambiguous" || status == "degenerate" ? kYellow : kRed;
}

}  // namespace

std::string colored_status(std::string_view status) {
  if (!has_colors()) return std::string(status);
  return fmt::format("\033[{}m{}\033[0m", color_of(status), status);
}

void print_next(const CommonOptions& common, const std::string& next) {
  if (!common.json && !common.quiet) fmt::print("Next: {}\n", next);
}

Notice::Notice(std::string what, bool quiet) {
  if (quiet || isatty(STDERR_FILENO) == 0) return;
  clock_ = std::jthread([what = std::move(what)](const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any ended;
    std::unique_lock lock(mutex);
    int seconds = 0;
    do {
      const std::string elapsed = seconds < kUnannounced ? "" : fmt::format(" {} s", seconds);
      fmt::print(stderr, "\r{} ...{}\033[K", what, elapsed);
      std::fflush(stderr);
      ++seconds;
    } while (!ended.wait_for(lock, stop, std::chrono::seconds(1),
                             [&stop] { return stop.stop_requested(); }));
    fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
  });
}

Notice::~Notice() = default;  // which stops the clock and waits for its line to be gone

}  // namespace palpate::app
