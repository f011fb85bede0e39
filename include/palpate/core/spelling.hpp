// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace palpate {

/// How far a word is from another: the Levenshtein distance (insertions, deletions and
/// replacements) over the length of the longer word. 0: equal, 1: nothing in common.
double spelling_distance(std::string_view a, std::string_view b);

/// A word no farther from what was written is likely what was meant.
inline constexpr double kLikelyMeant = 0.5;

/// "; did you mean 'pick'?" for what resembles one of the names, else empty.
std::string did_you_mean(std::string_view given, std::span<const std::string> names);

}  // namespace palpate
