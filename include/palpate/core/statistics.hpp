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

/// 95 % confidence interval of the mean, of normal values or enough of them (Student 1908).
/// @throws BadInput for fewer than two values
Interval mean_interval(const std::vector<double>& values);

/// How many values fall into each of `bins` equal bins from `low` to `high`; both ends belong to
/// the bins, values beyond are not counted.
/// @throws BadInput for no bins, or unless low < high
std::vector<std::size_t> histogram(const std::vector<double>& values, double low, double high,
                                   std::size_t bins);

}  // namespace palpate
