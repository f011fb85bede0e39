// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "core/error_message.hpp"
#include "hand_files.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"

namespace palpate::simulation {

inline DescribedHand described(const std::string& name, const std::string& text,
                               const HandNotes& notes = {}) {
  return describe_hand(write_hand(name, text), notes);
}

/// The hand of two fingers and a thumb, with more after its bodies.
inline DescribedHand hand_with(const std::string& more, const HandNotes& notes = {}) {
  return described("hand.xml", replaced(kHandMjcf, "</worldbody>", "</worldbody>" + more), notes);
}

inline std::string why_not(const std::string& more, const HandNotes& notes = {}) {
  return error_message([&] { hand_with(more, notes); });
}

inline const hand::Actuator& actuator(const DescribedHand& described, const std::string& name) {
  const hand::Description& hand = described.hand;
  return hand.actuators[static_cast<std::size_t>(hand.actuator(name))];
}

inline bool says(const std::vector<std::string>& texts, const std::string& part) {
  return std::ranges::any_of(
      texts, [&](const auto& text) { return text.find(part) != std::string::npos; });
}

inline bool reports(const DescribedHand& described, const std::string& part) {
  return std::ranges::any_of(described.problems, [&](const HandProblem& problem) {
    return (problem.what + ": " + problem.hint).find(part) != std::string::npos;
  });
}

}  // namespace palpate::simulation
