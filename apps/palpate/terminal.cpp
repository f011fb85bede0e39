// SPDX-License-Identifier: Apache-2.0
#include "terminal.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace palpate::app {
namespace {

bool has_colors() {
  const char* const refused = std::getenv("NO_COLOR");
  return isatty(STDOUT_FILENO) != 0 && !(refused && *refused);
}

int color_of(std::string_view status) {
  constexpr int kRed = 31, kGreen = 32, kYellow = 33;
  if (status == "ok" || status == "certain" || status == "found") return kGreen;
  return status == "ambiguous" ? kYellow : kRed;
}

}  // namespace

std::string colored_status(std::string_view status) {
  if (!has_colors()) return std::string(status);
  return fmt::format("\033[{}m{}\033[0m", color_of(status), status);
}

void print_next(const CommonOptions& common, const std::string& next) {
  if (!common.json && !common.quiet) fmt::print("Next: {}\n", next);
}

Notice::Notice(std::string_view what, bool quiet) : shown_(!quiet && isatty(STDERR_FILENO) != 0) {
  if (shown_) fmt::print(stderr, "{} ...", what);
  if (shown_) std::fflush(stderr);
}

Notice::~Notice() {
  if (shown_) fmt::print(stderr, "\r\033[K");
}

}  // namespace palpate::app
