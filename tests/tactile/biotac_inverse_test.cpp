// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/error_message.hpp"
#include "palpate/core/array_file.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/tactile/biotac/dataset.hpp"
#include "palpate/tactile/biotac/decoder.hpp"
#include "palpate/tactile/biotac/inverse.hpp"

namespace palpate::tactile {
namespace {

std::vector<BiotacFrame> touches(std::uint64_t seed, int count) {
  BiotacDatasetOptions options;
  options.trajectories = count;
  options.seconds = 1;
  options.stride = 10;
  options.seed = seed;
  return simulate_biotac(options);
}

const BiotacInverse& trained() {
  static const auto model = BiotacInverse::train(touches(1, 150));
  return model;
}

TEST(BiotacDecoder, TakesOutCreepAndTemperature) {
  const BiotacSkin skin;
  BiotacSensorOptions options;
  options.noise = 0;
  BiotacSensor sensor(skin, options, RandomStream(1));
  BiotacDecoder decoder(sensor.rest(), options);
  const hand::TipContact contact{.p = {0.007, 0, 0}, .n = {-1, 0, 0}, .f = {3, 0, 0}};
  const auto state = skin.press({&contact, 1});
  const Eigen::VectorXd expected = BiotacElectrodes(skin, options).resistances(state);
  for (int k = 0; k < 40; ++k) {
    const auto decoded = decoder.step(sensor.step(state, 26));
    EXPECT_LT((decoded->resistances - expected).cwiseAbs().maxCoeff(), 0.004);  // rounding
  }
}

TEST(BiotacDecoder, RefusesFaultyReadings) {
  const BiotacSkin skin;
  const BiotacSensor sensor(skin, {}, RandomStream(1));
  BiotacDecoder decoder(sensor.rest(), {});
  auto reading = sensor.rest();
  EXPECT_TRUE(decoder.step(reading));
  for (const double count : {0.0, 4095.0, -1.0, 5000.0, std::nan("")}) {
    reading.electrodes[4] = count;
    EXPECT_FALSE(decoder.step(reading)) << count;
  }
}

TEST(BiotacInverse, FindsUnseenContacts) {
  std::vector<double> points, forces;
  for (const auto& frame : touches(2, 60)) {
    const auto found = trained().estimate(frame.decoded);
    if (!found) continue;
    points.push_back((found->p - frame.p).norm());
    forces.push_back((found->f - frame.f1).norm());
  }
  EXPECT_GT(points.size(), 200u);
  EXPECT_LT(median(points), 0.0007);
  EXPECT_LT(median(forces), 0.15);
}

TEST(BiotacInverse, IsAsSureAsItIsRight) {
  int within = 0, total = 0;
  for (const auto& frame : touches(3, 60)) {
    const auto found = trained().estimate(frame.decoded);
    if (!found) continue;
    const auto error = contact_error(*found, frame.p, frame.f1);
    for (int k = 0; k < 5; ++k) {
      within += std::abs(error[k]) < std::sqrt(found->covariance(k, k));
      ++total;
    }
  }
  EXPECT_GT(within, 0.58 * total);  // 0.68 where exactly calibrated
  EXPECT_LT(within, 0.78 * total);
}

TEST(BiotacInverse, SaysNothingWithoutContact) {
  DecodedReading reading{.resistances = Eigen::VectorXd::Zero(kElectrodes), .pressure = 2};
  EXPECT_FALSE(trained().estimate(reading));
  reading.pressure = 100;
  EXPECT_TRUE(trained().estimate(reading));
  reading.resistances[3] = std::nan("");
  EXPECT_FALSE(trained().estimate(reading));
}

TEST(BiotacInverse, IsRefusedWhereItIsNone) {
  const std::string good = trained().bytes();
  EXPECT_EQ(BiotacInverse::parse(good, "i.model").bytes(), good);
  const auto says = [](const std::string& bytes) {
    return error_message([&] { (void)BiotacInverse::parse(bytes, "i.model"); });
  };
  EXPECT_NE(says(good.substr(0, 500)), "");
  ArrayFile other("biotac-inverse", 2);
  other.add("hidden", Eigen::MatrixXf::Constant(1, 1, 2.5f));
  EXPECT_NE(says(other.bytes()).find("2.5 hidden"), std::string::npos);
}

}  // namespace
}  // namespace palpate::tactile
