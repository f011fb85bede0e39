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
  const long hours = whole / 3600, minutes = whole / 60 % 60;
  if (hours > 0) return fmt::format("{}:{:02}:{:02}", hours, minutes, whole % 60);
  return fmt::format("{}:{:02}", minutes, whole % 60);
}

}  // namespace

std::string progress_bar(std::size_t done, std::size_t total, double elapsed) {
  const double share =
      total == 0 ? 1.0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  const auto filled = static_cast<std::size_t>(share * kWidth);
  const std::string left = done == 0 ? "?" : clock(elapsed * (1 - share) / share);
  const auto percent = static_cast<int>(100 * share);  // 100 only when all is done
  return fmt::format("{:3}% [{}{}] {}/{}  {} passed, {} left", percent, std::string(filled, '='),
                     std::string(kWidth - filled, ' '), done, total, clock(elapsed), left);
}

}  // namespace palpate
