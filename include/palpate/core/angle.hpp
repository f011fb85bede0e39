// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace palpate {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180;            ///< rad
inline constexpr double kDegreesPerRadian = 180 / kPi;  ///< of a value in rad, to print it

}  // namespace palpate
