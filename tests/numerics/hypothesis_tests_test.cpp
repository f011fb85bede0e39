// SPDX-License-Identifier: Apache-2.0
#include "palpate/numerics/hypothesis_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"

namespace palpate::numerics {
namespace {

// The expected values are those of SciPy 1.17.1 (shapiro, bartlett, f_oneway, ttest_ind with
// equal_var=False, mannwhitneyu with method="exact" or, of many values, "asymptotic"; with ties all
// ways to deal the values to two samples were enumerated).

const std::vector<double> kA = {3.1, 4.7, 5.2, 2.8, 6.4, 5.9, 4.1, 3.3, 7.7, 4.9, 5.5, 6.0};
const std::vector<double> kB = {2.1, 9.4, 3.3, 7.9, 1.2, 11.5, 6.6, 4.4, 5.2, 0.4, 8.8};
const std::vector<double> kTied = {4.0, 4.0, 5.2, 5.9, 6.1, 3.3, 4.7};
const std::vector<double> kSkewed = {0.1, 0.2, 0.2, 0.3, 0.3, 0.4,  0.5, 0.6,
                                     0.9, 1.5, 2.7, 6.1, 9.9, 14.0, 30.5};

void expect_result(const TestResult& result, double statistic, double p) {
  EXPECT_NEAR(result.statistic, statistic, 1e-8 * std::max(1.0, std::abs(statistic)));
  EXPECT_NEAR(result.p, p, 1e-8);
}

/// W and p of Royston's approximation differ between programs in late digits.
void expect_shapiro(const std::vector<double>& values, double w, double p) {
  const TestResult result = shapiro_wilk(values);
  EXPECT_NEAR(result.statistic, w, 1e-6);
  EXPECT_NEAR(result.p, p, 1e-5);
}

TEST(HypothesisTests, ShapiroWilk) {
  expect_shapiro(kA, 0.9695841366421549, 0.906399051456919);
  expect_shapiro(kB, 0.9661647207142359, 0.8454068295187063);
  expect_shapiro(kTied, 0.9425150299735602, 0.6614676391324192);
  expect_shapiro(kSkewed, 0.6065626556239014, 2.9271710713552546e-05);
  expect_shapiro({1, 2, 4}, 0.9642857142857142, 0.6368868450289689);
  expect_shapiro({1, 2, 4, 9, 3}, 0.8669607110584259, 0.2543338401775038);
}

TEST(HypothesisTests, ShapiroWilkIsBlindToShiftAndScale) {
  std::vector<double> moved;
  for (const double value : kSkewed) moved.push_back(1000 - 3 * value);
  EXPECT_NEAR(shapiro_wilk(moved).statistic, shapiro_wilk(kSkewed).statistic, 1e-9);
}

TEST(HypothesisTests, ShapiroWilkRejectsFalselyAsOftenAsItSays) {
  palpate::RandomStream random(5);
  int rejected = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    std::vector<double> values(30);
    for (double& value : values) value = random.normal();
    rejected += shapiro_wilk(values).p < 0.05;
  }
  EXPECT_NEAR(rejected, 50, 28);  // four standard deviations of 1000 trials at 5 %
}

TEST(HypothesisTests, Bartlett) {
  expect_result(bartlett({kA, kB}), 7.463212487476756, 0.006297252853768556);
  expect_result(bartlett({kA, kB, kTied}), 12.90442836490534, 0.001577026475763332);
}

TEST(HypothesisTests, OneWayAnova) {
  expect_result(one_way_anova({kA, kB}), 0.2446098868374032, 0.6260307271666224);
  expect_result(one_way_anova({kA, kB, kTied}), 0.2594509098047377, 0.7733765200727029);
}

TEST(HypothesisTests, Welch) {
  expect_result(welch(kA, kB), -0.47861302307131925, 0.6401905260852452);
  expect_result(welch(kA, kSkewed), 0.19243916388224103, 0.8499652308166996);
}

TEST(HypothesisTests, MannWhitney) {
  expect_result(mann_whitney({1, 2, 3}, {4, 5, 6}), 0, 0.1);
  expect_result(mann_whitney({1, 2, 3, 9}, {4, 5, 6, 7, 8}), 5, 0.2857142857142857);
  expect_result(mann_whitney({1, 1, 2}, {1, 2, 2}), 3, 1);  // every sum is as far from the middle
  expect_result(mann_whitney(kA, kTied), 46, 0.7569460982773676);
  expect_result(mann_whitney(kTied, kB), 34, 0.7078619909502263);
  EXPECT_EQ(mann_whitney({1, 1, 1}, {1, 1}).p, 1);
}

TEST(HypothesisTests, MannWhitneyOfManyValuesIsAsymptotic) {
  std::vector<double> a, b;
  for (const double by : {0.0, 0.5, -0.25}) {
    for (const double value : kA) a.push_back(value + by);
  }
  for (const double by : {0.0, 0.7}) {
    for (const double value : kB) b.push_back(value + by);
  }
  expect_result(mann_whitney(a, b), 351, 0.47569063736879225);
}

TEST(HypothesisTests, HedgesG) { EXPECT_NEAR(hedges_g(kA, kB), -0.1989875250310455, 1e-12); }

TEST(HypothesisTests, MeanInterval) {
  const palpate::Interval interval = palpate::mean_interval(kA);
  EXPECT_NEAR(interval.low, 4.036280095061206, 1e-9);
  EXPECT_NEAR(interval.high, 5.897053238272128, 1e-9);
}

TEST(HypothesisTests, BootstrapDifference) {
  // SciPy's bootstrap, percentile, of 200000 resamples.
  const palpate::Interval interval = bootstrap_difference(kA, kB, 20000, palpate::RandomStream(1));
  EXPECT_NEAR(interval.low, -2.7636, 0.06);
  EXPECT_NEAR(interval.high, 1.6008, 0.06);
}

TEST(HypothesisTests, NormalPlotOfNormalQuantilesIsAStraightLine) {
  auto plot = normal_plot(kA);
  EXPECT_TRUE(std::is_sorted(plot.values.begin(), plot.values.end()));
  EXPECT_NEAR(plot.quantiles.front(), -1.6350392668017106, 1e-12);  // SciPy's norm.ppf
  EXPECT_NEAR(plot.quantiles.back(), -plot.quantiles.front(), 1e-12);
}

TEST(HypothesisTests, HistogramCountsEachValueOnce) {
  const auto counts = palpate::histogram({0, 0.1, 0.5, 0.99, 1, 1.1, -0.1}, 0, 1, 2);
  EXPECT_EQ(counts, (std::vector<std::size_t>{2, 3}));
  EXPECT_THROW(palpate::histogram({1}, 1, 1, 2), palpate::BadInput);
  EXPECT_THROW(palpate::histogram({1}, 0, 1, 0), palpate::BadInput);
}

TEST(HypothesisTests, NamesTheTestThatIsValid) {
  const palpate::RandomStream random(1);
  EXPECT_EQ(
      compare_samples(kA, {4.0, 4.0, 5.2, 5.9, 6.1, 3.3, 4.7, 5.1, 4.4, 6.6}, random).valid_test,
      "anova");
  EXPECT_EQ(compare_samples(kA, kB, random).valid_test, "welch");
  const auto skewed = compare_samples(kA, kSkewed, random);
  EXPECT_EQ(skewed.valid_test, "mann_whitney");
  EXPECT_NE(skewed.reason.find("Shapiro-Wilk"), std::string::npos);
}

TEST(HypothesisTests, OfThreeValuesOnlyRanksAreBelieved) {
  const auto few = compare_samples({1, 2, 3}, {4, 5, 6}, palpate::RandomStream(1));
  EXPECT_EQ(few.valid_test, "mann_whitney");
  EXPECT_NE(few.reason.find("3 and 3 values"), std::string::npos);
  EXPECT_NE(few.reason.find("0.1"), std::string::npos);  // what three against three can reach
  EXPECT_NEAR(few.mann_whitney.p, 0.1, 1e-12);
  EXPECT_FALSE(compare_samples({1, 2}, {4, 6}, palpate::RandomStream(1)).normality_a);
}

TEST(HypothesisTests, OfMoreThan5000ValuesNormalityIsLeftOut) {
  std::vector<double> many;
  for (int i = 0; i < 5001; ++i) many.push_back(i % 13);
  const auto result = compare_samples(many, kA, palpate::RandomStream(1));
  EXPECT_FALSE(result.normality_a);
  EXPECT_TRUE(result.normality_b && result.welch && result.bartlett);
  EXPECT_EQ(result.valid_test, "mann_whitney");
  EXPECT_NE(result.reason.find("5001 and"), std::string::npos) << result.reason;
  many.pop_back();
  EXPECT_TRUE(compare_samples(many, kA, palpate::RandomStream(1)).normality_a);
}

TEST(HypothesisTests, ConstantSamplesAreExplained) {
  const palpate::RandomStream random(1);
  const auto one = compare_samples(kA, std::vector<double>(12, 3.0), random);
  EXPECT_EQ(one.valid_test, "mann_whitney");
  EXPECT_NE(one.reason.find("all values of B are 3"), std::string::npos);
  EXPECT_FALSE(one.bartlett || one.normality_a);
  EXPECT_TRUE(one.welch);
  const auto both = compare_samples({2, 2, 2, 2}, {5, 5, 5, 5}, random);
  EXPECT_NE(both.reason.find("nothing varies"), std::string::npos);
  EXPECT_FALSE(both.welch || both.anova || both.effect);
  EXPECT_EQ(both.difference, -3);
  EXPECT_EQ(compare_samples({2, 2, 2}, {2, 2, 2}, random).mann_whitney.p, 1);
}

TEST(HypothesisTests, RejectsWhatCannotBeTested) {
  EXPECT_THROW(shapiro_wilk({1, 2}), palpate::BadInput);
  EXPECT_THROW(shapiro_wilk({3, 3, 3}), palpate::BadInput);
  EXPECT_THROW(bartlett({kA}), palpate::BadInput);
  EXPECT_THROW(bartlett({kA, {2, 2, 2}}), palpate::BadInput);
  EXPECT_THROW(one_way_anova({{1, 1}, {2, 2}}), palpate::BadInput);
  EXPECT_THROW(welch({1}, kA), palpate::BadInput);
  EXPECT_THROW(mann_whitney({}, kA), palpate::BadInput);
  EXPECT_THROW(hedges_g({1, 1}, {2, 2}), palpate::BadInput);
}

}  // namespace
}  // namespace palpate::numerics
