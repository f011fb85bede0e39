// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace palpate {

/// How library code reports its progress.
using ProgressCallback = std::function<void(std::size_t done, std::size_t total)>;

/// One line that shows how far a work is: percent, bar, count, time passed and time left.
/// @param elapsed  s; the time left follows from it, all items taken to be equally long
std::string progress_bar(std::size_t done, std::size_t total, double elapsed);

}  // namespace palpate
