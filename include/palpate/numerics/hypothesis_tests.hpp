// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/core/statistics.hpp"

namespace palpate::numerics {

/// A test's statistic and the probability of one at least as extreme if there is no effect.
struct TestResult {
  double statistic = 0;
  double p = 1;
};

/// Whether values are normal: W near 1 if so (Shapiro & Wilk 1965; p by Royston 1995, AS R94).
/// @throws BadInput for fewer than 3 or more than 5000 values, or equal ones
TestResult shapiro_wilk(const std::vector<double>& values);

using Samples = std::vector<std::vector<double>>;

// The tests of samples throw BadInput for fewer than two samples, or one of fewer than two values.

/// Whether normal samples have equal variances (Bartlett 1937). @throws BadInput also if one has
/// none
TestResult bartlett(const Samples& samples);

/// Whether normal samples of equal variance have equal means (Fisher 1925).
TestResult one_way_anova(const Samples& samples);

/// Whether two normal samples have equal means, whatever their variances (Welch 1947); two-sided.
TestResult welch(const std::vector<double>& a, const std::vector<double>& b);

/// Whether a value of one sample is as often above as below one of the other (Mann & Whitney 1947);
/// two-sided. Of at most 50 values p is exact, by the distribution of the rank sum over all ways to
/// deal the values to the samples, ties included; of more by the normal approximation with
/// corrections for ties and continuity.
/// The statistic is the number of pairs in which a's value is above, ties half.
TestResult mann_whitney(const std::vector<double>& a, const std::vector<double>& b);

/// Difference of the means over the pooled standard deviation (Cohen 1988), without its bias in
/// small samples (Hedges 1981).
double hedges_g(const std::vector<double>& a, const std::vector<double>& b);

/// 95 % confidence interval of mean(a) - mean(b): percentiles of resampled differences (Efron
/// 1979).
palpate::Interval bootstrap_difference(const std::vector<double>& a, const std::vector<double>& b,
                                       int resamples, palpate::RandomStream random);

/// Points of a normal plot: the values in order against the quantiles of a standard normal at
/// (i - 3/8) / (n + 1/4) (Blom 1958). A straight line means normal.
struct NormalPlot {
  std::vector<double> quantiles, values;
};
NormalPlot normal_plot(std::vector<double> values);

/// Everything about the difference of two samples, and which test may be believed. What does not
/// exist for samples of fewer than 3 values, or of equal ones, is missing, and so is the normality
/// of more than 5000.
struct Comparison {
  std::optional<TestResult> normality_a, normality_b, bartlett, anova, welch;
  TestResult mann_whitney;
  std::optional<double> effect;       ///< Hedges' g
  double difference = 0;              ///< mean(a) - mean(b)
  palpate::Interval difference_ci95;  ///< by bootstrap
  std::string valid_test;             ///< "anova", "welch" or "mann_whitney"
  std::string reason;
};

/// Compares two samples. The valid test follows from the assumptions, tested at 5 %: analysis of
/// variance needs normality and equal variances, Welch's test only normality, that of Mann and
/// Whitney neither. Of fewer than 10 values, or more than 5000, normality cannot be tested, so that
/// leaves the last.
Comparison compare_samples(const std::vector<double>& a, const std::vector<double>& b,
                           palpate::RandomStream random);

}  // namespace palpate::numerics
