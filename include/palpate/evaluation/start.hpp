// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "palpate/simulation/world/world.hpp"

namespace palpate::evaluation {

/// m, that the object may be beyond the bounds of its rough place.
inline constexpr double kPlaceMargin = 0.005;

/// How the object starts; drawn at random where nothing is fixed.
struct StartOptions {
  int stable_pose = -1;       ///< index into KnownObject::stable_poses; -1: drawn by probability
  double x = 0, y = 0;        ///< m, of its rough place on the table
  double uncertainty = 0.04;  ///< m: its centroid is within +- of there, as the robot believes
  double spread = 0;          ///< m: within +- of there, in truth; 0: as the robot believes

  [[nodiscard]] double half_width() const { return spread > 0 ? spread : uncertainty; }

  template <class Visitor>
  void visit(Visitor&& v) {
    v("stable_pose", stable_pose, -1, 1000,
      "index of the initial stable pose; -1: drawn by probability");
    v("uncertainty", uncertainty, 0.0, 0.1,
      "m, the object is within +- this of its approximate position");
    v.expert("spread", spread, 0.0, 0.2,
             "m, the object starts within +- this of its approximate position; 0: uncertainty");
    v.expert("x", x, -3.0, 3.0, "m, approximate position of the object, as in --at");
    v.expert("y", y, -3.0, 3.0, "m, approximate position of the object, as in --at");
  }
};

/// Where the hand waits before a pick.
hand::HandCommand waiting_command(const hand::Description& hand);

/// Draws where the object of a trial starts.
/// @throws BadInput for a stable pose that the object does not have
simulation::Start draw_start(const geometry::KnownObject& object, const StartOptions& options,
                             std::uint64_t seed);

/// Resets a world to a start from which the object does not leave its rough place before the hand
/// comes: on a table that is tilted, round objects may roll away from a pose that is stable on a
/// level one. Such a start is drawn again, and the first one kept if none of ten is better.
/// @return the start
/// @throws BadInput as draw_start()
simulation::Start start_trial(simulation::World& world, const geometry::KnownObject& object,
                              const StartOptions& options, std::uint64_t seed);

}  // namespace palpate::evaluation
