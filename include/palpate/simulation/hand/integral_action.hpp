// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/description.hpp"

namespace palpate::simulation {

/// The I of the hand's PID controllers; P and D are those of the position servos.
struct IntegralOptions {
  double time = 0.5;        ///< s, in which the integral of a constant error equals P
  double limit = 0.03;      ///< N m, of the integral: a few times what holds a joint by friction
  double deadband = 0.004;  ///< rad, of error left alone: joints would hunt about their friction

  template <class Visitor>
  void visit(Visitor&& v) {
    v("time", time, 0.01, 100.0,
      "s, time in which the integral of a constant error equals the proportional action");
    v("limit", limit, 0.0, 1.0, "N m, largest integral action");
    v("deadband", deadband, 0.0, 0.1, "rad, error below which the integral stays");
  }
};

/// Integrates the servos' errors. The integral is clamped, so that it never winds up against a
/// contact; a limit of 0 leaves the servos PD controllers.
class IntegralAction {
 public:
  explicit IntegralAction(const IntegralOptions& options) : options_(options) {}

  /// Torques to add after another `dt` seconds, N m.
  /// @param errors  command less position, rad
  /// @param stiffness  P, N m/rad
  const hand::ActuatorVector& update(const hand::ActuatorVector& errors,
                                     const hand::ActuatorVector& stiffness, double dt);
  void reset() { torques_.setZero(); }

 private:
  IntegralOptions options_;
  hand::ActuatorVector torques_;
};

}  // namespace palpate::simulation
