// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "common.hpp"

namespace palpate::app {

/// A status in its color where stdout is a terminal and NO_COLOR is not set: green for what is done
/// or certain, yellow for ambiguous, red for the others.
std::string colored_status(std::string_view status);

/// "Next: ..." after a command's results, for a person.
void print_next(const CommonOptions& common, const std::string& next);

/// "what ..." on stderr, if that is a terminal, while something takes time; gone when it is over.
class Notice {
 public:
  Notice(std::string_view what, bool quiet);
  ~Notice();
  Notice(const Notice&) = delete;
  Notice& operator=(const Notice&) = delete;

 private:
  bool shown_;
};

}  // namespace palpate::app
