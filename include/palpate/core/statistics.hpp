// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace palpate {

// Every statistic of values throws BadInput if there are none or one is nan.

double mean(const std::vector<double>& values);

/// Standard deviation of a sample (n - 1). @throws BadInput for fewer than two values
double standard_deviation(const std::vector<double>& values);

/// Value below which the given share (0..1) of the values lies, interpolated linearly between the
/// order statistics (Hyndman & Fan 1996, type 7). @throws BadInput for a share outside 0..1
double quantile(std::vector<double> values, double share);

inline double median(const std::vector<double>& values) { return quantile(values, 0.5); }

struct Interval {
  double low, high;
};

/// 95 % confidence interval of a rate (Wilson 1927; Newcombe 1998, method 3).
/// @throws BadInput for no trials, or more successes than trials
Interval wilson_interval(std::size_t successes, std::size_t trials);

}  // namespace palpate
