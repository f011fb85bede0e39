// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "core/error_message.hpp"
#include "palpate/core/array_file.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/tactile/biotac/electrodes.hpp"
#include "tactile/biotac_logs.hpp"

namespace palpate::tactile {
namespace {

/// A sensor that is not the default one, seen in a turned and mirrored frame.
ElectrodeFit another_sensor() {
  ElectrodeFit sensor;
  sensor.skin.stiffness = 1.5e8;
  sensor.skin.crown = 0.04;
  sensor.sensor.spread = 0.003;
  sensor.sensor.bulge_area = 2e-4;
  sensor.R_sensor_log = exp_so3({0.1, -0.08, 0.05});
  sensor.mirrored = true;
  return sensor;
}

std::vector<BiotacSample> samples_of(const ElectrodeFit& sensor, std::uint64_t seed, int count) {
  RandomStream random(seed, "electrodes");
  std::vector<BiotacSample> samples;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d n(random.uniform(-0.9, 0.1), random.uniform(-0.6, 0.6), 1);
    BiotacSample sample{.change = BiotacChannels::Zero(), .n = n.normalized()};
    sample.change[0] = random.uniform(30, 500);
    samples.push_back(sample);
  }
  const Eigen::MatrixXd changes = sensor.changes(samples);
  for (int i = 0; i < count; ++i) {
    auto& change = samples[static_cast<std::size_t>(i)].change;
    for (int e = 0; e < kElectrodes; ++e) change[1 + e] = changes(e, i) + random.normal();
  }
  return samples;
}

TEST(ElectrodeFit, FindsTheSensorThatMadeTheLog) {
  const ElectrodeFit truth = another_sensor();
  ElectrodeFitOptions options;
  options.samples = 60;
  const ElectrodeFit found = fit_electrodes(samples_of(truth, 1, 60), options);
  EXPECT_TRUE(found.mirrored);
  EXPECT_NEAR(found.skin.stiffness / truth.skin.stiffness, 1, 0.05);
  EXPECT_NEAR(found.skin.crown / truth.skin.crown, 1, 0.15);
  EXPECT_NEAR(found.sensor.spread / truth.sensor.spread, 1, 0.05);
  EXPECT_NEAR(found.sensor.bulge_area / truth.sensor.bulge_area, 1, 0.05);
  EXPECT_LT(rotation_distance(found.R_sensor_log, truth.R_sensor_log), 0.03);
}

TEST(ElectrodeFit, IsRefusedTooFewSamples) {
  const auto few = samples_of({}, 1, 5);
  EXPECT_NE(error_message([&] { (void)fit_electrodes(few); }).find("5 samples"), std::string::npos);
  EXPECT_NE(error_message([&] { (void)ElectrodeModel::train(few); }).find("5 samples"),
            std::string::npos);
  EXPECT_NE(error_message([&] { (void)evaluate_electrodes(few, {}); }), "");
}

double error_over_size(const ElectrodeModel& model, const std::vector<BiotacSample>& samples) {
  double error = 0, size = 0;
  for (const auto& sample : samples) {
    const auto truth = sample.change.tail<kElectrodes>();
    error += (model(sample.n, sample.change[0]) - truth).cwiseAbs().sum();
    size += truth.cwiseAbs().sum();
  }
  return error / size;
}

TEST(ElectrodeModel, LearnsWhatElectrodesShow) {
  const ElectrodeFit sensor = another_sensor();
  const auto model = ElectrodeModel::train(samples_of(sensor, 1, 500));
  const auto other = samples_of(sensor, 2, 200);
  EXPECT_LT(error_over_size(model, other), 0.15);
  EXPECT_EQ(cross_validate_electrodes({}), std::nullopt);
}

TEST(ElectrodeModel, BearsTouchesThatMetTheFingerElsewhere) {
  const ElectrodeFit sensor = another_sensor();
  auto samples = samples_of(sensor, 1, 300);
  for (std::size_t i = 0; i < samples.size(); i += 8) samples[i].change[3] -= 400;
  const auto model = ElectrodeModel::train(samples);
  // Least squares would spread an eighth of 400 counts over that electrode.
  double shift = 0;
  const auto other = samples_of(sensor, 2, 100);
  for (const auto& sample : other) {
    shift += std::abs(model(sample.n, sample.change[0])[2] - sample.change[3]) / 100;
  }
  EXPECT_LT(shift, 25);
}

TEST(ElectrodeModel, LongTouchesDoNotOutvoteShortOnes) {
  const ElectrodeFit sensor = another_sensor();
  auto samples = samples_of(sensor, 1, 100);
  const auto model = ElectrodeModel::train(samples);
  for (int k = 0; k < 3000; ++k) samples.push_back(samples[0]);
  const auto other = samples_of(sensor, 2, 100);
  EXPECT_LT(error_over_size(ElectrodeModel::train(samples), other),
            1.1 * error_over_size(model, other));
}

TEST(ElectrodeModel, IsRefusedWhereItIsNone) {
  const auto model = ElectrodeModel::train(samples_of({}, 1, 40));
  const std::string good = model.bytes();
  EXPECT_EQ(ElectrodeModel::parse(good, "e.model").bytes(), good);
  const auto says = [](const std::string& bytes) {
    return error_message([&] { (void)ElectrodeModel::parse(bytes, "e.model"); });
  };
  EXPECT_NE(says(good.substr(0, 300)).find("e.model"), std::string::npos);
  std::string damaged = good;
  damaged[good.size() / 2] = static_cast<char>(damaged[good.size() / 2] ^ 0x40);
  EXPECT_NE(says(damaged), "");
  ArrayFile old("biotac-electrodes", 7);
  EXPECT_NE(says(old.bytes()), "");
  EXPECT_NE(error_message([&] { (void)model(Eigen::Vector3d::UnitZ(), 0); }), "");
  EXPECT_NE(error_message([&] { (void)model({std::nan(""), 0, 1}, 100); }), "");
}

/// The touches of made_up_log() as that sensor would report them.
BiotacLog log_of(const ElectrodeFit& sensor, std::uint64_t seed, int touches) {
  BiotacLog log = made_up_log(seed, touches);
  RandomStream random(seed, "counts");
  for (std::size_t i = 0; i < log.channels.size(); ++i) {
    BiotacSample sample{.change = BiotacChannels::Zero(), .n = *log.normals[i]};
    sample.change[0] = log.channels[i][0] - 2410;
    const Eigen::MatrixXd change = sensor.changes({sample});
    for (int e = 0; e < kElectrodes; ++e) {
      const double counts = sample.change[0] > 20 ? change(e, 0) : 0;
      log.channels[i][1 + e] = std::round(3200 + 10 * e + counts + random.normal());
    }
  }
  return log;
}

TEST(ElectrodeModel, MeetsTheTargetOnTouchesOfLogsThatItHasNotSeen) {
  ElectrodeFitOptions fit;
  fit.samples = 40;
  for (const auto& log : logs_on_file(log_of(another_sensor(), 6, 8))) {
    SCOPED_TRACE(log.name);
    const auto errors = cross_validate_electrodes({log}, fit);
    ASSERT_TRUE(errors);
    EXPECT_LT(errors->model.mean(), 0.33);
    EXPECT_LT(errors->fit.mean(), 0.6);  // of the real log 0.72 without a look at the contact
  }
}

}  // namespace
}  // namespace palpate::tactile
