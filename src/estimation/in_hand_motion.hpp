// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "palpate/estimation/event_log.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/localization/posterior.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::estimation {

using Fingers = hand::PerFinger<bool>;

/// How the object has moved in the hand's mount between two readings.
struct InHandMotion {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  /// Axes (m, in the mount) about which it may have turned by its own weight without a fingertip
  /// that measures it: through the contacts, where only one or two carried it. Empty: three or
  /// more did.
  std::vector<localization::FreeAxis> loose = {};
};

/// Contacts roll along the fingertips while they carry the object, so that the way is followed step
/// by step.
/// @param ignored  fingers that do not hold it
InHandMotion in_hand_motion(const hand::Description& hand, const EventLog& log, std::size_t first,
                            std::size_t last, const tactile::ContactErrorModel& errors,
                            const Fingers& ignored = {});

}  // namespace palpate::estimation
