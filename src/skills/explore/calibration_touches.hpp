// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/skills/explore/calibrate_phase.hpp"

namespace palpate::skills {

/// A posture and an attitude of the mount in which one fingertip is the lowest part of the hand.
struct CalibrationTouch {
  int finger = 0;
  hand::ActuatorVector posture;
  hand::Attitude attitude;                          ///< of the mount
  Eigen::Vector2d aside = Eigen::Vector2d::Zero();  ///< of the place where the table is bare, m

  /// @param height  of the mount, m
  [[nodiscard]] hand::MountPosition mount(const CalibrateOptions& options, double height) const;
};

/// The touches that are most informative about where fingertips are in grasps, in an order in which
/// it does not take long from one to the next.
std::vector<CalibrationTouch> calibration_touches(const hand::Description& hand,
                                                  const CalibrateOptions& options);

/// The touch in which a fingertip is lowest by most; none where it never is alone the lowest.
std::optional<CalibrationTouch> calibration_touch(const hand::Description& hand, int finger);

/// Fingertips in grasps: each finger somewhere on its way from the open to the closed hand.
std::vector<tactile::TipPosture> fingertips_in_grasps(const hand::Description& hand);

/// What is believed of mount and table before they are touched.
tactile::MountPrior mount_prior(const CalibrateOptions& options);

}  // namespace palpate::skills
