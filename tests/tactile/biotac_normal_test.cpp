// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "core/error_message.hpp"
#include "palpate/core/array_file.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/tactile/biotac/normal.hpp"
#include "tactile/biotac_logs.hpp"

namespace palpate::tactile {
namespace {

BiotacNormalOptions small() {
  BiotacNormalOptions options;
  options.centres = 250;
  return options;
}

const BiotacNormalModel& trained() {
  static const auto model = BiotacNormalModel::train(biotac_samples(made_up_log(1, 6)), small());
  return model;
}

std::vector<double> errors_at(const BiotacNormalModel& model, const BiotacLog& log) {
  std::vector<double> errors;
  for (const auto& sample : biotac_samples(log)) {
    errors.push_back(angle_between_deg(model.estimate(sample.change)->n, sample.n));
  }
  return errors;
}

TEST(BiotacNormal, FindsNormalsOfAnotherLog) {
  const auto errors = errors_at(trained(), made_up_log(2, 6));
  EXPECT_GT(errors.size(), 700u);
  EXPECT_LT(median(errors), 5);  // of plates tilted by up to 35 deg
}

TEST(BiotacNormal, IsAsSureAsItIsRight) {
  double squared = 0, familiar = 0;
  int count = 0;
  for (const auto& sample : biotac_samples(made_up_log(2, 6))) {
    const auto found = trained().estimate(sample.change);
    const double error = angle_between_deg(found->n, sample.n) * 3.14159 / 180;
    squared += error * error / (2 * found->sigma * found->sigma);
    familiar += found->novelty;
    ++count;
  }
  EXPECT_GT(squared / count, 0.2);  // 1 where exactly calibrated
  EXPECT_LT(squared / count, 5);
  const auto strange = trained().estimate(BiotacChannels::Constant(1500));
  EXPECT_GT(strange->novelty, 10 * familiar / count);
}

TEST(BiotacNormal, SaysNothingWithoutPressureOrNumbers) {
  BiotacChannels change = BiotacChannels::Constant(-50);
  EXPECT_FALSE(trained().estimate(change));
  change[0] = 100;
  EXPECT_TRUE(trained().estimate(change));
  change[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(trained().estimate(change));
}

TEST(BiotacNormal, IsTheSameAfterReadingItBack) {
  const auto again = BiotacNormalModel::parse(trained().bytes(), "model");
  EXPECT_EQ(again.bytes(), trained().bytes());
  for (const auto& sample : biotac_samples(made_up_log(3, 1))) {
    const auto a = trained().estimate(sample.change), b = again.estimate(sample.change);
    EXPECT_LT(angle_between_deg(a->n, b->n), 0.1);  // float32 on file
    EXPECT_NEAR(a->sigma, b->sigma, 0.01);
  }
}

TEST(BiotacNormal, RefusesFilesThatAreNoModel) {
  const std::string good = trained().bytes();
  const auto says = [](const std::string& bytes) {
    return error_message([&] { (void)BiotacNormalModel::parse(bytes, "x.model"); });
  };
  EXPECT_EQ(says(good), "");
  EXPECT_NE(says("").find("x.model"), std::string::npos);
  EXPECT_NE(says(good.substr(0, good.size() / 2)).find("cut short"), std::string::npos);
  EXPECT_NE(says(good + "x").find("too many"), std::string::npos);
  auto changed = good;
  changed[good.size() - 100] ^= 1;
  EXPECT_NE(says(changed).find("sum"), std::string::npos);
  auto later = good;
  later.replace(later.find(" 1\n"), 3, " 2\n");
  EXPECT_NE(says(later).find("version 2"), std::string::npos);
  EXPECT_NE(says(ArrayFile("policy", 1).bytes()).find("policy"), std::string::npos);
  ArrayFile other("biotac-normal", 1);
  other.add("settings", Eigen::MatrixXf::Zero(7, 1));
  EXPECT_NE(says(other.bytes()).find("settings is 7 x 1"), std::string::npos);
}

TEST(BiotacNormal, RefusesToLearnFromNothing) {
  EXPECT_NE(error_message([] { (void)BiotacNormalModel::train({}); }).find("0 samples"),
            std::string::npos);
}

TEST(BiotacNormal, ValidatesOnTouchesItDidNotLearn) {
  const auto errors = cross_validate_biotac_normal({made_up_log(4, 8)}, small());
  EXPECT_GT(errors.size(), 1000u);
  EXPECT_LT(median(errors), 6);
}

TEST(BiotacNormal, MeetsItsTargetOnRealTouchesLeftOut) {
  PALPATE_NEEDS_REAL_DATA(kRealLog);
  const auto log = read_biotac_log(*real_data(kRealLog));
  const auto errors = cross_validate_biotac_normal({log});
  EXPECT_GT(errors.size(), 3000u);
  EXPECT_LE(median(errors), 5);
  EXPECT_LE(quantile(errors, 0.9), 15);
}

}  // namespace
}  // namespace palpate::tactile
