// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "palpate/hand/hand.hpp"

namespace palpate::pipeline {

/// Moments of a pick that matter to the estimator.
enum class Mark {
  felt,    ///< the flat hand rests on the object's top
  closed,  ///< the fingers hold the object, which still stands on the table
  held,    ///< the object hangs in the hand, settled
};
inline constexpr std::array<std::string_view, 3> kMarkNames = {"felt", "closed", "held"};

/// All that was felt, and when what was reached: everything that the pose estimate depends on.
struct TouchLog {
  std::vector<hand::HandReading> readings;            ///< one a tick
  std::array<std::optional<std::size_t>, 3> marks{};  ///< index into readings, latest of its kind

  std::optional<std::size_t> at(Mark mark) const { return marks[static_cast<std::size_t>(mark)]; }
};

}  // namespace palpate::pipeline
