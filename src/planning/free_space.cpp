// SPDX-License-Identifier: Apache-2.0
#include "planning/free_space.hpp"

#include <cmath>

#include "palpate/hand/kinematics.hpp"

namespace palpate::planning {

bool HandSpace::is_free(const Coordinates& configuration) {
  const hand::HandCommand command = command_of(configuration);
  const auto joints = hand::joints_in_free_flexion(scene_.hand(), command.positions);
  return !scene_.deepest_collision(command.mount, joints);
}

bool FreeSpace::holds(const Coordinates& configuration) {
  ++checks_;
  return is_free(configuration);
}

bool FreeSpace::holds_piece(const PathPiece& piece) {
  const int steps = 1 + static_cast<int>(piece.length / step_);
  for (int i = 1; i <= steps; ++i) {
    if (!holds(piece.at(piece.length * i / steps))) return false;
  }
  return true;
}

bool FreeSpace::holds_line(const Coordinates& start, const Coordinates& end) {
  const double length = distance(start, end, metric_);
  if (length == 0) return holds(end);
  return holds_piece({.start = start,
                      .direction = (end - start) / length,
                      .bend = Coordinates::Zero(start.size()),
                      .length = length});
}

}  // namespace palpate::planning
