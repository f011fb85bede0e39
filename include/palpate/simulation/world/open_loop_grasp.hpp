// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/grasping/closing_law.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::simulation {

/// A grasp by set moves, which regards no sensor but that of the load on the mount: to study
/// contacts in, where the pick of the pipeline would take long and be beside the point.
struct OpenLoopGrasp {
  Start start;            ///< of the object
  bool side = true;       ///< from the side, else from above
  double height = 0.073;  ///< m, of the mount when it closes
  double grip = 1.0;      ///< of the holding torques
  double close_seconds = 1.5;
  double lift_seconds = 1.0;
  double hold_seconds = 0.5;
};

/// Approaches, closes with limited torque, lifts by 10 cm and holds.
/// @param last  if not null, gets the command that holds the object at the end
/// @return whether the object hangs in the hand at the end
bool run_open_loop_grasp(World& world, const OpenLoopGrasp& grasp,
                         hand::HandCommand* last = nullptr);

}  // namespace palpate::simulation
