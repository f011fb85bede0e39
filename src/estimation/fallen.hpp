// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "palpate/estimation/estimate.hpp"

namespace palpate::estimation {

inline constexpr double kFallenTilt = 0.12;  // rad
inline constexpr double kFallenWay = 0.05;   // m

/// For an object that has fallen: it may rest beside its stable poses, in a pose that a small push
/// would end, and it may have rolled.
/// @param place  where it was touched, m
inline EstimationOptions of_fallen(EstimationOptions options, const Eigen::Vector2d& place) {
  options.resting_tilt_sigma = std::max(options.resting_tilt_sigma, kFallenTilt);
  options.resting_half_width = std::max(options.resting_half_width,
                                        kFallenWay + (place - options.place).cwiseAbs().maxCoeff());
  return options;
}

}  // namespace palpate::estimation
