// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr std::size_t kWidth = 30;  // characters

std::string clock(double seconds) {
  const auto whole = static_cast<long>(std::lround(seconds));
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

std::string progress_bar(std::size_t done, std::size_t total, double elapsed) {
  const double share =
      total == 0 ? 1.0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  const auto filled = static_cast<std::size_t>(share * kWidth);
  const std::string left = done == 0 ? "?" : clock(elapsed * (1 - share) / share);
  return fmt::format("[{}{}] {}/{}  {} passed, {} left", std::string(filled, '='),
                     std::string(kWidth - filled, ' '), done, total, clock(elapsed), left);
}

}  // namespace palpate
