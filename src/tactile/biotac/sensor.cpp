// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/biotac/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::tactile {
namespace {

constexpr double kReferenceTemperature = 30;  // deg C, at which the rest values hold
constexpr double kRoom = 23;                  // deg C, of what is touched
constexpr double kTemperatureRest = 2000, kAlternatingRest = 2000;  // counts
constexpr double kPacLow = 10, kPacHigh = 1040;                     // Hz, of the band of pac

}  // namespace

Eigen::Matrix<double, 3, kElectrodes> electrode_positions() {
  Eigen::Matrix<double, 3, kElectrodes> p;  // mm; Ruppel et al. 2019
  p << 0.993, -2.7, -6.2, -8, -10.5, -13.4, 4.763, 3.031, 3.031, 1.299, 0.993, -2.7, -6.2, -8,
      -10.5, -13.4, -2.8, -9.8, -13.6,  //
      -4.855, -3.513, -3.513, -4.956, -3.513, -4.956, 0, -1.95, 1.95, 0, 4.855, 3.513, 3.513, 4.956,
      3.513, 4.956, 0, 0, 0,  //
      -1.116, -3.67, -3.67, -1.116, -3.67, -1.116, -2.33, -3.33, -3.33, -4.33, -1.116, -3.67, -3.67,
      -1.116, -3.67, -1.116, -5.08, -5.08, -5.08;
  return p * 1e-3;
}

Eigen::Matrix<double, kElectrodes, 1> electrode_rest() {
  // Rounded rest values of a real BioTac (EPFL LASA logs, 2019).
  Eigen::Matrix<double, kElectrodes, 1> rest;
  rest << 2990, 3440, 3410, 3220, 3350, 3080, 3140, 3220, 3230, 3290, 3030, 3470, 3440, 3230, 3350,
      3060, 3400, 3370, 3100;
  return rest;
}

BiotacChannels channels_of(const BiotacReading& reading) {
  BiotacChannels result;
  result << reading.pdc, reading.electrodes;
  return result;
}

BiotacElectrodes::BiotacElectrodes(const BiotacSkin& skin, const BiotacSensorOptions& options)
    : skin_(&skin),
      gap_(options.gap),
      min_gap_(options.min_gap),
      bulge_area_(options.bulge_area),
      drag_(options.drag / skin.options().shear_stiffness),
      view_(kElectrodes, kTaxels) {
  const auto electrodes = electrode_positions();
  slope_.fill(Eigen::MatrixXd(kElectrodes, kTaxels));
  const double variance = options.spread * options.spread;
  for (int j = 0; j < kElectrodes; ++j) {
    const Eigen::Vector3d above = skin.on_skin(electrodes.col(j));
    const Eigen::Matrix3Xd away = skin.points().colwise() - above;
    view_.row(j) = (-away.colwise().squaredNorm().array() / (2 * variance)).exp().matrix();
    view_.row(j) /= view_.row(j).sum();
    for (int axis = 0; axis < 3; ++axis) {
      slope_[static_cast<std::size_t>(axis)].row(j) =
          -view_.row(j).cwiseProduct(away.row(axis)) / variance;
    }
  }
}

Eigen::VectorXd BiotacElectrodes::resistances(const SkinState& state) const {
  const double bulge = state.depth.dot(skin_->areas()) / bulge_area_;
  const Eigen::ArrayXd gaps = (gap_ + bulge - state.depth.array()).max(min_gap_);
  const Eigen::VectorXd thinned = view_ * (gap_ / gaps).matrix();
  // The mean of -g0 div u in an electrode's view is g0 sum u . grad w.
  Eigen::VectorXd dragged = Eigen::VectorXd::Zero(kElectrodes);
  for (int axis = 0; axis < 3; ++axis) {
    dragged += slope_[static_cast<std::size_t>(axis)] * state.shear.row(axis).transpose();
  }
  return thinned.array() * (drag_ * dragged.array()).exp() - 1;
}

BiotacSensor::BiotacSensor(const BiotacSkin& skin, const BiotacSensorOptions& options,
                           const RandomStream& random)
    : skin_(&skin),
      electrodes_(skin, options),
      options_(options),
      origin_(random),
      random_(random) {
  reset();
}

BiotacReading BiotacSensor::rest() const {
  BiotacReading reading;
  reading.pdc = options_.pressure_rest;
  reading.tdc = kTemperatureRest;
  reading.tac = kAlternatingRest;
  reading.pac.fill(kAlternatingRest);
  reading.electrodes = electrode_rest();
  return reading;
}

void BiotacSensor::reset() {
  random_ = origin_;
  late_ = Eigen::VectorXd::Zero(kElectrodes);
  last_pressure_ = high_ = low_ = last_input_ = 0;
  frame_ = 0;
}

void BiotacSensor::reseed(const RandomStream& random) {
  origin_ = random;
  reset();
}

double BiotacSensor::counts(double value) {
  return std::clamp(std::round(value + options_.noise * random_.normal()), 0.0,
                    hand::kBiotacFullScale);
}

void BiotacSensor::fill_pressure(double force, BiotacReading& reading) {
  const double pressure = options_.pressure_gain * force;
  const double dt = kBiotacPeriod / kPacSamples;
  const double keep_high = 1 / (1 + 2 * std::numbers::pi * kPacLow * dt);
  const double rc = 1 / (2 * std::numbers::pi * kPacHigh);
  const double take_low = dt / (dt + rc);
  for (int k = 0; k < kPacSamples; ++k) {
    const double share = (k + 1.0) / kPacSamples;
    const double input = last_pressure_ + share * (pressure - last_pressure_);
    high_ = keep_high * (high_ + input - last_input_);
    low_ += take_low * (high_ - low_);
    last_input_ = input;
    reading.pac[static_cast<std::size_t>(k)] = counts(kAlternatingRest + options_.pac_gain * low_);
  }
  last_pressure_ = pressure;
  reading.pdc = counts(options_.pressure_rest + pressure);
}

BiotacReading BiotacSensor::step(const SkinState& state, double temperature) {
  BiotacReading reading;
  reading.time = kBiotacPeriod * frame_++;
  fill_pressure(state.pressure.dot(skin_->areas()), reading);
  const Eigen::VectorXd change = electrodes_.resistances(state);
  late_ += (1 - std::exp(-kBiotacPeriod / options_.creep_time)) * (change - late_);
  const Eigen::VectorXd ratio =
      1 + ((1 - options_.creep_share) * change + options_.creep_share * late_).array();
  const double warmth = temperature - kReferenceTemperature;
  const auto rest = electrode_rest();
  for (int j = 0; j < kElectrodes; ++j) {
    // At rest R_j0 / R_ref = 4095 / counts - 1.
    const double relative = (hand::kBiotacFullScale / rest[j] - 1) * ratio[j] /
                            std::max(0.1, 1 + options_.conductivity * warmth);
    reading.electrodes[j] = counts(hand::kBiotacFullScale / (1 + relative));
  }
  const double touched =
      (state.pressure.array() > 0).select(skin_->areas().array(), 0.0).sum() * 1e4;  // cm^2
  reading.tdc = counts(kTemperatureRest + options_.temperature_gain * warmth);
  reading.tac = counts(kAlternatingRest + options_.heat_gain * touched * (temperature - kRoom));
  return reading;
}

}  // namespace palpate::tactile
