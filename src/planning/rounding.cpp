// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "palpate/planning/trajectory.hpp"

namespace palpate::planning {
namespace {

Coordinates unit_tangent(const Coordinates& from, const Coordinates& to,
                         const Coordinates& metric) {
  return (to - from) / distance(from, to, metric);
}

/// Quadratic Bezier arc with legs of equal length: its tangent is of unit length at both ends.
PathPiece arc(const Coordinates& corner, const Coordinates& in, const Coordinates& out,
              double cut) {
  const double length = 2 * cut;
  return {
      .start = corner - cut * in, .direction = in, .bend = (out - in) / length, .length = length};
}

}  // namespace

std::vector<PathPiece> rounded(const std::vector<Coordinates>& corners,
                               const std::vector<double>& cuts, const Coordinates& metric) {
  constexpr double kMinLine = 1e-9;  // m, shorter lines between two arcs are left out
  std::vector<PathPiece> path;
  double cut_before = 0;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const double side = distance(corners[i], corners[i + 1], metric);
    const Coordinates along = unit_tangent(corners[i], corners[i + 1], metric);
    const bool last = i + 2 == corners.size();
    const double next_side = last ? 0 : distance(corners[i + 1], corners[i + 2], metric);
    const double cut = last ? 0 : std::min({cuts[i + 1], 0.5 * side, 0.5 * next_side});
    const double straight = side - cut_before - cut;
    if (straight > kMinLine) {
      path.push_back({.start = corners[i] + cut_before * along,
                      .direction = along,
                      .bend = Coordinates::Zero(along.size()),
                      .length = straight});
    }
    if (cut > 0) {
      const Coordinates next = unit_tangent(corners[i + 1], corners[i + 2], metric);
      path.push_back(arc(corners[i + 1], along, next, cut));
    }
    cut_before = cut;
  }
  return path;
}

}  // namespace palpate::planning
