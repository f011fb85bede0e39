// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace palpate {

inline constexpr double kGravity = 9.81;  ///< m/s^2, downwards

}  // namespace palpate
