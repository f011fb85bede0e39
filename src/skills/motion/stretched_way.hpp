// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "palpate/hand/hand.hpp"

namespace palpate::skills {

/// A way of one command a tick, in another number of ticks: on the straight lines between its
/// commands, the first of which comes a tick after `from`. The same way if the number is the same.
std::vector<hand::HandCommand> stretched(const hand::HandCommand& from,
                                         std::span<const hand::HandCommand> way, std::size_t ticks);

}  // namespace palpate::skills
