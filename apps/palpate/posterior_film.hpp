// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/recording/recording.hpp"
#include "palpate/simulation/rendering/renderer.hpp"

namespace palpate::app {

/// How a film of a posterior is taken.
struct FilmOptions {
  double speed = 8;           ///< times the robot's
  double picture_time = 0.1;  ///< s that each picture stays
  double last_time = 1.5;     ///< s that the last one stays
  simulation::Camera camera;  ///< looks at where the object was at first
};

/// Pictures of a pick from the first guarded move until the object hangs in the hand. The object is
/// drawn at the poses that are credible after the touches so far, the more opaque the likelier,
/// and not where it is; one search a touch.
/// @param recording  with the truth of the hand's joints
/// @throws BadInput for a recording without a guarded move
std::vector<simulation::Image> film_posterior(const recording::Recording& recording,
                                              simulation::Renderer& renderer,
                                              const FilmOptions& options);

}  // namespace palpate::app
