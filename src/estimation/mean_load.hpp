// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/event_log.hpp"

namespace palpate::estimation {

/// Mean of what the base carries over the last readings (N, up positive).
double mean_load(const EventLog& log, std::size_t readings = 20);

/// Mean of where the base was over the last readings.
hand::BasePosition mean_base(const EventLog& log, std::size_t readings = 20);

}  // namespace palpate::estimation
