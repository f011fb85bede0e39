// SPDX-License-Identifier: Apache-2.0
#include "palpate/touch/biotac_decoder.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::touch {
namespace {

constexpr double kTop = 4095;

}  // namespace

BiotacDecoder::BiotacDecoder(const BiotacReading& rest, const BiotacSensorOptions& sensor)
    : rest_(rest), sensor_(sensor), late_(Eigen::VectorXd::Zero(kElectrodes)) {}

std::optional<DecodedReading> BiotacDecoder::step(const BiotacReading& reading) {
  const auto sound = [](double count) { return count > 0 && count < kTop; };
  bool usable = sound(reading.pdc) && sound(reading.tdc);
  for (const double count : reading.electrodes) usable = usable && sound(count);
  if (!usable) return std::nullopt;
  const double warmth = (reading.tdc - rest_.tdc) / sensor_.temperature_gain;
  const double conductivity = std::max(0.1, 1 + sensor_.conductivity * warmth);
  Eigen::VectorXd change(kElectrodes);
  for (int j = 0; j < kElectrodes; ++j) {
    change[j] =
        conductivity * (kTop / reading.electrodes[j] - 1) / (kTop / rest_.electrodes[j] - 1) - 1;
  }
  // Measured: (1 - c) x + c late, where late follows x with share a of the difference a frame.
  const double a = 1 - std::exp(-kBiotacPeriod / sensor_.creep_time), c = sensor_.creep_share;
  DecodedReading decoded;
  decoded.resistances = (change - c * (1 - a) * late_) / (1 - c + c * a);
  late_ += a * (decoded.resistances - late_);
  decoded.pressure = reading.pdc - rest_.pdc;
  return decoded;
}

}  // namespace palpate::touch
