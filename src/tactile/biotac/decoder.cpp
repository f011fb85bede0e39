// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/biotac/decoder.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::tactile {
namespace {}  // namespace

BiotacDecoder::BiotacDecoder(const BiotacReading& rest, const BiotacSensorOptions& sensor)
    : rest_(rest), sensor_(sensor), late_(Eigen::VectorXd::Zero(kElectrodes)) {}

std::optional<DecodedReading> BiotacDecoder::step(const BiotacReading& reading) {
  const auto sound = [](double count) { return count > 0 && count < hand::kBiotacFullScale; };
  bool usable = sound(reading.pdc) && sound(reading.tdc);
  for (const double count : reading.electrodes) usable = usable && sound(count);
  if (!usable) return std::nullopt;
  const double warmth = (reading.tdc - rest_.tdc) / sensor_.temperature_gain;
  const double conductivity = std::max(0.1, 1 + sensor_.conductivity * warmth);
  Eigen::VectorXd change(kElectrodes);
  for (int j = 0; j < kElectrodes; ++j) {
    change[j] = conductivity * (hand::kBiotacFullScale / reading.electrodes[j] - 1) /
                    (hand::kBiotacFullScale / rest_.electrodes[j] - 1) -
                1;
  }
  // Measured: (1 - c) x + c late, where late follows x with share a of the difference a frame.
  const double a = 1 - std::exp(-kBiotacPeriod / sensor_.creep_time), c = sensor_.creep_share;
  Eigen::VectorXd values(kElectrodes + 1);
  values.head(kElectrodes) = (change - c * (1 - a) * late_) / (1 - c + c * a);
  values[kElectrodes] = reading.pdc - rest_.pdc;
  late_ += a * (values.head(kElectrodes) - late_);
  const Eigen::VectorXd smooth = smoothed(values);
  return DecodedReading{.resistances = smooth.head(kElectrodes), .pressure = smooth[kElectrodes]};
}

Eigen::VectorXd BiotacDecoder::smoothed(const Eigen::VectorXd& values) {
  constexpr auto kSize = static_cast<std::size_t>(kWindow);
  if (window_.size() < kSize) {
    window_.push_back(values);
  } else {
    window_[frames_ % kSize] = values;
  }
  const std::size_t n = window_.size();
  Eigen::VectorXd end = Eigen::VectorXd::Zero(values.size());
  for (std::size_t age = 0; age < n; ++age) {
    const double weight =
        (2.0 * (2.0 * static_cast<double>(n) - 1) - 6.0 * static_cast<double>(age)) /
        (static_cast<double>(n) * (static_cast<double>(n) + 1));
    end += weight * window_[(frames_ + kSize - age) % kSize];
  }
  ++frames_;
  return end;
}

void BiotacDecoder::forget_window() {
  window_.clear();
  frames_ = 0;
}

double BiotacDecoder::noise_left() {
  constexpr double n = kWindow;
  return std::sqrt(2 * (2 * n - 1) / (n * (n + 1)));
}

}  // namespace palpate::tactile
