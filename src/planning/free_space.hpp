// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/planning/collision_checker.hpp"
#include "palpate/planning/trajectory.hpp"

namespace palpate::planning {

/// Configurations without a collision; counts how often that was asked.
class FreeSpace {
 public:
  /// @param metric  metres of path a unit of each coordinate
  /// @param step  m of path between the configurations of a way that are checked
  FreeSpace(const Coordinates& metric, double step) : metric_(metric), step_(step) {}
  virtual ~FreeSpace() = default;

  [[nodiscard]] bool holds(const Coordinates& configuration);
  [[nodiscard]] bool holds_line(const Coordinates& start, const Coordinates& end);
  [[nodiscard]] bool holds_piece(const PathPiece& piece);

  [[nodiscard]] const Coordinates& metric() const { return metric_; }
  [[nodiscard]] double step() const { return step_; }
  void halve_step() { step_ *= 0.5; }
  [[nodiscard]] int checks() const { return checks_; }

 private:
  [[nodiscard]] virtual bool is_free(const Coordinates& configuration) = 0;

  Coordinates metric_;
  double step_;
  int checks_ = 0;
};

/// What the hand on a floating mount may do.
class HandSpace : public FreeSpace {
 public:
  HandSpace(CollisionChecker& scene, double step)
      : FreeSpace(planning::metric(scene.hand()), step), scene_(scene) {}

 private:
  bool is_free(const Coordinates& configuration) override;

  CollisionChecker& scene_;
};

}  // namespace palpate::planning
