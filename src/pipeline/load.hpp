// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/pipeline/touch_log.hpp"

namespace palpate::pipeline {

inline constexpr double kGravity = 9.81;  // m/s^2

/// Mean of what the base carries over the last readings (N, up positive).
double mean_load(const TouchLog& log, std::size_t readings = 20);

/// Mean of where the base was over the last readings.
hand::BasePosition mean_base(const TouchLog& log, std::size_t readings = 20);

}  // namespace palpate::pipeline
