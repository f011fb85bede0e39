// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/tactile/biotac/log.hpp"

namespace palpate::tactile {

inline constexpr double kPressureDrift = 15;   ///< counts since the start, worth telling
inline constexpr double kElectrodeDrift = 30;  ///< counts
inline constexpr int kStuckFrames = 60;        ///< equal counts in a row ...
inline constexpr double kStuckPressure = 60;   ///< ... while the pressure spans this, counts

inline unsigned bit(BiotacFlag flag) { return static_cast<unsigned>(flag); }

/// What is wrong with a frame's counts by themselves.
unsigned count_flags(const BiotacChannels& channels);

/// Whether the rest values have moved far since the start.
bool far_from(const BiotacChannels& rest, const BiotacChannels& start);

}  // namespace palpate::tactile
