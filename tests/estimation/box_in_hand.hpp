// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "hand/descriptions.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/localization/posterior.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::estimation {

inline localization::Posterior at(const Eigen::Vector3d& place) {
  localization::Mode mode;
  mode.T_frame_object.translation() = place;
  mode.weight = 1;
  mode.covariance = 1e-6 * Matrix6d::Identity();
  return {localization::PoseStatus::certain, {mode}, {}, 0};
}

/// The box and the Shadow hand, and what it senses from tick to tick.
class BoxInHandTest : public testing::Test {
 protected:
  BoxInHandTest()
      : object(geometry::load_known_object("box")),
        hand(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"))) {}

  /// A reading with the mount at that place, a finger touching or not.
  hand::HandReading reading(const Eigen::Vector3d& mount, bool touches) {
    hand::HandReading result = hand::resting_reading();
    result.time = hand::kTick * tick++;
    result.mount.xyz = mount;
    if (touches) {
      const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
      result.contacts[1].push_back({.p = 0.02 * z, .n = -z, .f = 2 * z});
    }
    return result;
  }

  geometry::ObjectModel object;
  hand::Description hand;
  int tick = 0;
};

}  // namespace palpate::estimation
