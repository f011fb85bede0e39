// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/planning/collision_checker.hpp"
#include "palpate/planning/trajectory.hpp"

namespace palpate::planning {

/// What the hand may do without a collision; counts how often that was asked.
class FreeSpace {
 public:
  /// @param step  m of path between the configurations of a way that are checked
  FreeSpace(CollisionChecker& scene, double step)
      : scene_(&scene), metric_(planning::metric(scene.hand())), step_(step) {}

  [[nodiscard]] bool holds(const Coordinates& configuration);
  [[nodiscard]] bool holds_line(const Coordinates& start, const Coordinates& end);
  [[nodiscard]] bool holds_piece(const PathPiece& piece);

  /// Metres of path a unit of each coordinate.
  [[nodiscard]] const Coordinates& metric() const { return metric_; }
  [[nodiscard]] double step() const { return step_; }
  void halve_step() { step_ *= 0.5; }
  [[nodiscard]] int checks() const { return checks_; }

 private:
  CollisionChecker* scene_;
  Coordinates metric_;
  double step_;
  int checks_ = 0;
};

}  // namespace palpate::planning
