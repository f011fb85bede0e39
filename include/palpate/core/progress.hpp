// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace palpate {

/// One line that shows how far a work is: bar, count, time passed and time left.
/// @param elapsed  s
std::string progress_bar(std::size_t done, std::size_t total, double elapsed);

}  // namespace palpate
