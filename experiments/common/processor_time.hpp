// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <time.h>

#include <ctime>

namespace palpate::experiment {

/// Of this thread, s: other programs on the machine do not count.
inline double processor_seconds() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace palpate::experiment
