// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "palpate/estimation/estimate.hpp"

namespace palpate::estimation {

/// The readings of the last `seconds` up to one of them, with it.
std::span<const hand::HandReading> window_before(const EventLog& log, std::size_t index,
                                                 double seconds);

/// The readings that belong to an event of that kind at a reading: the last ones up to it, during
/// which the hand stood as it did then. They are averaged.
std::span<const hand::HandReading> event_window(const EventLog& log, TouchEvent event,
                                                std::size_t reading,
                                                const EstimationOptions& options);

}  // namespace palpate::estimation
