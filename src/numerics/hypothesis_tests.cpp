// SPDX-License-Identifier: Apache-2.0
#include "palpate/numerics/hypothesis_tests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate::numerics {
namespace {

namespace bm = boost::math;

constexpr double kLevel = 0.05;
constexpr int kResamples = 10000;
constexpr std::size_t kExact = 50;  // values, up to which the distribution of ranks is counted out
constexpr std::size_t kShapiroWilk = 3, kMinForNormality = 10;  // values
constexpr std::size_t kMaxForNormality = 5000;                  // up to which its p is known

double size(const std::vector<double>& values) { return static_cast<double>(values.size()); }

double variance(const std::vector<double>& values) {
  const double sd = standard_deviation(values);
  return sd * sd;
}

void check(const Samples& samples) {
  if (samples.size() < 2) {
    throw palpate::BadInput(
        fmt::format("{} samples to compare, at least 2 needed", samples.size()));
  }
  for (const auto& sample : samples) {
    if (sample.size() < 2) {
      throw palpate::BadInput(
          fmt::format("a sample of {} values, at least 2 needed", sample.size()));
    }
  }
}

/// A value and whether it is of the first sample.
struct Tagged {
  double value;
  bool first;
};

std::vector<Tagged> merged(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<Tagged> all;
  for (const double value : a) all.push_back({value, true});
  for (const double value : b) all.push_back({value, false});
  std::sort(all.begin(), all.end(),
            [](const Tagged& x, const Tagged& y) { return x.value < y.value; });
  return all;
}

/// Sum of the first sample's ranks, ties ranked in their middle; and the sum of t^3 - t over ties.
struct Ranks {
  double first = 0, ties = 0;
};

Ranks rank(const std::vector<Tagged>& all) {
  Ranks ranks;
  for (std::size_t start = 0; start < all.size();) {
    std::size_t end = start;
    while (end < all.size() && all[end].value == all[start].value) ++end;
    const double middle = static_cast<double>(start + end + 1) / 2;
    for (std::size_t i = start; i < end; ++i) ranks.first += all[i].first ? middle : 0;
    const double t = static_cast<double>(end - start);
    ranks.ties += t * t * t - t;
    start = end;
  }
  return ranks;
}

double resampled_mean(const std::vector<double>& values, palpate::RandomStream& random) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) sum += values[random.index(values.size())];
  return sum / size(values);
}

/// Doubled ranks, which are whole numbers also for ties.
std::vector<std::size_t> doubled_ranks(const std::vector<Tagged>& all) {
  std::vector<std::size_t> ranks;
  for (std::size_t start = 0; start < all.size();) {
    std::size_t end = start;
    while (end < all.size() && all[end].value == all[start].value) ++end;
    ranks.insert(ranks.end(), end - start, start + end + 1);
    start = end;
  }
  return ranks;
}

/// Share of all choices of `chosen` ranks whose sum is at least as far from the mean as `sum`; all
/// doubled. Counts the choices by number and sum, one rank after the other.
double exact_p(const std::vector<std::size_t>& ranks, std::size_t chosen, double sum) {
  const std::size_t total = std::accumulate(ranks.begin(), ranks.end(), std::size_t{0});
  std::vector<std::vector<double>> ways(chosen + 1, std::vector<double>(total + 1, 0));
  ways[0][0] = 1;
  for (const std::size_t rank : ranks) {
    for (std::size_t k = chosen; k > 0; --k) {
      for (std::size_t s = total; s >= rank; --s) ways[k][s] += ways[k - 1][s - rank];
    }
  }
  const double center = static_cast<double>(chosen * total) / static_cast<double>(ranks.size());
  const double away = std::abs(sum - center) - 0.25;  // sums are whole, the centre at most half
  double far = 0, all = 0;
  for (std::size_t s = 0; s <= total; ++s) {
    all += ways[chosen][s];
    if (std::abs(static_cast<double>(s) - center) > away) far += ways[chosen][s];
  }
  return far / all;
}

bool is_constant(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [&](double v) { return v == values.front(); });
}

/// Tests that samples of any size and spread allow.
void test_means(const std::vector<double>& a, const std::vector<double>& b,
                Comparison& comparison) {
  if (is_constant(a) && is_constant(b)) return;
  comparison.anova = one_way_anova({a, b});
  comparison.welch = welch(a, b);
  comparison.effect = hedges_g(a, b);
  if (is_constant(a) || is_constant(b)) return;
  comparison.bartlett = bartlett({a, b});
  if (std::min(a.size(), b.size()) < kShapiroWilk) return;
  if (a.size() <= kMaxForNormality) comparison.normality_a = shapiro_wilk(a);
  if (b.size() <= kMaxForNormality) comparison.normality_b = shapiro_wilk(b);
}

/// Least p that two samples of these sizes without ties can have.
double min_p(std::size_t na, std::size_t nb) {
  double ways = 1;
  for (std::size_t i = 1; i <= na; ++i) {
    ways *= static_cast<double>(nb + i) / static_cast<double>(i);
  }
  return std::min(2 / ways, 1.0);
}

/// Why no test but that of Mann and Whitney is left, or nothing if others may be.
std::string only_ranks(const std::vector<double>& a, const std::vector<double>& b) {
  if (is_constant(a) && is_constant(b)) {
    return fmt::format(
        "all values of A are {:g} and all of B {:g}: nothing varies that a test of "
        "means could go by",
        a.front(), b.front());
  }
  for (const auto& [name, values] : {std::pair{"A", &a}, {"B", &b}}) {
    if (!is_constant(*values)) continue;
    return fmt::format("all values of {} are {:g}, so it is not normal and has no variance", name,
                       values->front());
  }
  if (std::max(a.size(), b.size()) > kMaxForNormality) {
    return fmt::format(
        "{} and {} values are too many to test whether they are normal (Shapiro-Wilk: at most {} "
        "each)",
        a.size(), b.size(), kMaxForNormality);
  }
  if (std::min(a.size(), b.size()) >= kMinForNormality) return {};
  return fmt::format(
      "{} and {} values are too few to decide whether they are normal (at least {} "
      "each); the least p that they can have is {:.2g}",
      a.size(), b.size(), kMinForNormality, min_p(a.size(), b.size()));
}

void choose_test(const std::vector<double>& a, const std::vector<double>& b,
                 Comparison& comparison) {
  comparison.valid_test = "mann_whitney";
  comparison.reason = only_ranks(a, b);
  if (!comparison.reason.empty()) return;
  const double normality = std::min(comparison.normality_a->p, comparison.normality_b->p);
  if (normality < kLevel) {
    comparison.valid_test = "mann_whitney";
    comparison.reason = fmt::format(
        "normality is rejected (Shapiro-Wilk p = {:.2g}), so neither analysis of variance nor "
        "Welch's test is exact",
        normality);
  } else if (comparison.bartlett->p < kLevel) {
    comparison.valid_test = "welch";
    comparison.reason = fmt::format(
        "both samples pass for normal, but equal variances are rejected (Bartlett p = {:.2g}), "
        "which analysis of variance needs",
        comparison.bartlett->p);
  } else {
    comparison.valid_test = "anova";
    comparison.reason = "both samples pass for normal and of equal variance";
  }
}

}  // namespace

TestResult bartlett(const Samples& samples) {
  check(samples);
  const double k = static_cast<double>(samples.size());
  double freedom = 0, pooled = 0, logs = 0, inverse = 0;
  for (const auto& sample : samples) {
    const double n = size(sample) - 1, v = variance(sample);
    if (!(v > 0)) throw palpate::BadInput("equality of variances with a sample that has none");
    freedom += n;
    pooled += n * v;
    logs += n * std::log(v);
    inverse += 1 / n;
  }
  const double correction = 1 + (inverse - 1 / freedom) / (3 * (k - 1));
  const double statistic = (freedom * std::log(pooled / freedom) - logs) / correction;
  return {statistic, cdf(complement(bm::chi_squared(k - 1), std::max(statistic, 0.0)))};
}

TestResult one_way_anova(const Samples& samples) {
  check(samples);
  std::vector<double> all;
  for (const auto& sample : samples) all.insert(all.end(), sample.begin(), sample.end());
  const double grand = mean(all), k = static_cast<double>(samples.size());
  double between = 0, within = 0;
  for (const auto& sample : samples) {
    between += size(sample) * std::pow(mean(sample) - grand, 2);
    within += (size(sample) - 1) * variance(sample);
  }
  if (!(within > 0)) throw palpate::BadInput("analysis of variance of samples that have none");
  const double f = between / (k - 1) / (within / (size(all) - k));
  return {f, cdf(complement(bm::fisher_f(k - 1, size(all) - k), f))};
}

TestResult welch(const std::vector<double>& a, const std::vector<double>& b) {
  check({a, b});
  const double ea = variance(a) / size(a), eb = variance(b) / size(b);
  if (!(ea + eb > 0)) throw palpate::BadInput("a test of means of samples without variance");
  const double t = (mean(a) - mean(b)) / std::sqrt(ea + eb);
  const double freedom =
      (ea + eb) * (ea + eb) / (ea * ea / (size(a) - 1) + eb * eb / (size(b) - 1));
  return {t, 2 * cdf(complement(bm::students_t(freedom), std::abs(t)))};
}

TestResult mann_whitney(const std::vector<double>& a, const std::vector<double>& b) {
  check({a, b});
  const double na = size(a), nb = size(b), n = na + nb;
  const Ranks ranks = rank(merged(a, b));
  const double u = ranks.first - na * (na + 1) / 2;
  const double spread = std::sqrt(na * nb / 12 * (n + 1 - ranks.ties / (n * (n - 1))));
  if (!(spread > 0)) return {u, 1};  // all values are equal
  if (a.size() + b.size() <= kExact) {
    return {u, exact_p(doubled_ranks(merged(a, b)), a.size(), 2 * ranks.first)};
  }
  const double z = std::max(std::abs(u - na * nb / 2) - 0.5, 0.0) / spread;
  return {u, std::min(2 * cdf(complement(bm::normal(), z)), 1.0)};
}

double hedges_g(const std::vector<double>& a, const std::vector<double>& b) {
  check({a, b});
  const double freedom = size(a) + size(b) - 2;
  const double pooled = ((size(a) - 1) * variance(a) + (size(b) - 1) * variance(b)) / freedom;
  if (!(pooled > 0)) throw palpate::BadInput("an effect size of samples without variance");
  return (mean(a) - mean(b)) / std::sqrt(pooled) * (1 - 3 / (4 * freedom - 1));
}

palpate::Interval bootstrap_difference(const std::vector<double>& a, const std::vector<double>& b,
                                       int resamples, palpate::RandomStream random) {
  check({a, b});
  std::vector<double> differences;
  for (int i = 0; i < resamples; ++i) {
    const double of_a = resampled_mean(a, random);
    differences.push_back(of_a - resampled_mean(b, random));
  }
  return {quantile(differences, 0.025), quantile(differences, 0.975)};
}

NormalPlot normal_plot(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  NormalPlot plot;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double share = (static_cast<double>(i) + 0.625) / (size(values) + 0.25);
    plot.quantiles.push_back(bm::quantile(bm::normal(), share));
  }
  plot.values = std::move(values);
  return plot;
}

Comparison compare_samples(const std::vector<double>& a, const std::vector<double>& b,
                           palpate::RandomStream random) {
  Comparison result;
  test_means(a, b, result);
  result.mann_whitney = mann_whitney(a, b);
  result.difference = mean(a) - mean(b);
  result.difference_ci95 = bootstrap_difference(a, b, kResamples, random.fork("bootstrap"));
  choose_test(a, b, result);
  return result;
}

}  // namespace palpate::numerics
