// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <thread>

#include "common.hpp"

namespace palpate::app {

/// A status in its color where stdout is a terminal and NO_COLOR is not set: green for what is
/// done, certain or certified, yellow for ambiguous and degenerate, red for the others.
std::string colored_status(std::string_view status);

/// "Next: ..." after a command's results, for a person.
void print_next(const CommonOptions& common, const std::string& next);

/// "what ... 3 s" on stderr, if that is a terminal, while something takes time; gone when it is
/// over.
class Notice {
 public:
  Notice(std::string what, bool quiet);
  ~Notice();
  Notice(const Notice&) = delete;
  Notice& operator=(const Notice&) = delete;

 private:
  std::jthread clock_;
};

}  // namespace palpate::app
