// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/simulation/contact/sensor_noise.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// What one contact of the solver does to a fingertip.
struct FingertipTouch {
  int finger = 0;
  int other_geom = -1;       ///< what it touches
  hand::TipContact contact;  ///< in the frame of the tip's link, without noise; pressed: f.n < 0
};

/// @param tips  geom of each fingertip
/// @return nothing for a contact without a fingertip, or one that does not press
std::optional<FingertipTouch> read_fingertip_touch(const mjModel& model, const mjData& data,
                                                   int contact, const std::vector<int>& tips);

/// The contact as a noisy sensor gives it; nothing where the force drowns in the sensor's noise.
std::optional<hand::TipContact> with_sensor_noise(hand::TipContact contact,
                                                  const SensorNoise& noise, RandomStream& random);

}  // namespace palpate::simulation
