// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace palpate {

/// How far a word is from another: the optimal string alignment distance (insertions, deletions,
/// replacements and exchanges of neighbouring letters) over the length of the longer word. 0:
/// equal, 1: nothing in common.
double spelling_distance(std::string_view a, std::string_view b);

/// A word no farther from what was written is likely what was meant.
inline constexpr double kLikelyMeant = 1.0 / 3;

/// "; did you mean 'pick'?" for what resembles one of the names, else empty.
std::string did_you_mean(std::string_view given, std::span<const std::string> names);

}  // namespace palpate
