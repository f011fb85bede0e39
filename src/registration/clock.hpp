// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace palpate::registration {

/// Since some moment in the past, s.
inline double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace palpate::registration
