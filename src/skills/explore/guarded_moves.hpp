// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "palpate/skills/explore/explore_phase.hpp"

namespace palpate::skills {

/// m/s at which the lightest candidate is touched: what it takes to move an object grows with its
/// mass, and so does what a fingertip may meet it with.
double speed_of_touch(const estimation::Candidates& candidates, const ExploreOptions& options);

/// m above the table of the fingertip's centre in the first guarded moves.
double first_depth(const PickState& state, const ExploreOptions& options);

/// Where the object's middle is on the table: by the best pose, or, before there is any, its rough
/// place.
Eigen::Vector2d middle_of(const PickState& state, const geometry::KnownObject& object);

/// Level towards a place from an angle, passing it to the left by an offset.
localization::GuardedMove level_guarded_move(const Eigen::Vector2d& place,
                                             const ExploreOptions& options, double angle,
                                             double offset, double depth);

/// Level guarded moves from all sides, and past the object's place on both of them.
void add_level_guarded_moves(const PickState& state, const ExploreOptions& options, double depth,
                             std::vector<localization::GuardedMove>& guarded_moves);

/// Level ones from the least height of the fingertip up to the object's top, and downward ones.
/// @param above  m above the table, of a fingertip over the object
std::vector<localization::GuardedMove> disambiguating_moves(const PickState& state,
                                                            const ExploreOptions& options,
                                                            double above);

/// How the hand is turned for a guarded move, as shares of ExploreOptions::turn.
inline constexpr std::array<double, 4> kTurns = {0, 1, 0.5, -0.5};

/// Guarded moves that were not made yet, for each turn of the hand.
using UntriedMoves = std::array<std::vector<localization::GuardedMove>, kTurns.size()>;

/// The most informative one per second, which is then no longer among them. The hand is turned by a
/// quarter only where moves with the other turns are little informative.
/// @param fingers  for each turn, or only for the first two
/// @return nothing if none is informative
std::optional<localization::TurnedMove> take_most_informative(
    const std::vector<localization::PosedObject>& objects,
    const std::vector<localization::ProbingFinger>& fingers, UntriedMoves& untried);

}  // namespace palpate::skills
