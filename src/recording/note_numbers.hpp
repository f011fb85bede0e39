// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate::recording {

/// The numbers that follow a word in a note; none unless the note begins with it.
std::vector<double> numbers_after(std::string_view word, const std::string& text);

/// The same; none unless there are as many as there should be.
std::vector<double> numbers_after(std::string_view word, const std::string& text,
                                  std::size_t count);

inline constexpr std::string_view kTargetNote = "target ";
inline constexpr std::size_t kPoseNumbers = 16;

}  // namespace palpate::recording
