// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "palpate/estimation/event_log.hpp"

namespace palpate::estimation {

/// Mean of what the mount carries over the last readings (N, up positive), or all if they are
/// fewer.
/// @param log  with a reading at least
double mean_load(const EventLog& log, std::size_t readings = 20);

/// Mean of where the mount was (m, rad) in some readings, at least one.
hand::MountPosition mean_mount(std::span<const hand::HandReading> readings);

/// The same over the last readings.
hand::MountPosition mean_mount(const EventLog& log, std::size_t readings = 20);

}  // namespace palpate::estimation
