// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/localization/posterior.hpp"

namespace palpate::localization {

/// An unturned pose at a place (m).
inline Mode mode_at(const Eigen::Vector3d& place, double weight) {
  Mode mode;
  mode.T_frame_object.translation() = place;
  mode.weight = weight;
  return mode;
}

}  // namespace palpate::localization
