// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/tactile/biotac/sensor.hpp"

namespace palpate::tactile {

/// What the electrodes' counts say of the skin: R_j / R_j0 - 1 after a long time, and the pressure.
struct DecodedReading {
  Eigen::VectorXd resistances;  ///< kElectrodes relative changes, freed of temperature and creep
  double pressure = 0;          ///< change of pdc, counts
};

/// Takes temperature and creep out of a sensor's readings, frame by frame, and most of the noise.
///
/// The creep is linear in the resistances, so that its state follows from the readings alone. What
/// it gives is the end of a line fitted to the last frames (Savitzky & Golay 1964, order 1).
class BiotacDecoder {
 public:
  static constexpr int kWindow = 12;  ///< frames at most that the line is fitted to

  /// Standard deviation of the noise that the line leaves, as a share.
  static double noise_left();

  /// @param rest  a reading at rest
  BiotacDecoder(const BiotacReading& rest, const BiotacSensorOptions& sensor);

  /// Another reading at rest, for what has drifted.
  void set_rest(const BiotacReading& rest) { rest_ = rest; }

  /// Lets the line start again, after frames that were lost.
  void forget_window();

  /// The next frame, 10 ms after the last; nothing where a channel is not finite, outside 0..4095
  /// or at an end of that range.
  std::optional<DecodedReading> step(const BiotacReading& reading);

 private:
  Eigen::VectorXd smoothed(const Eigen::VectorXd& values);

  BiotacReading rest_;
  BiotacSensorOptions sensor_;
  Eigen::VectorXd late_;
  std::vector<Eigen::VectorXd> window_;  // resistances, then the pressure; a ring
  std::size_t frames_ = 0;
};

}  // namespace palpate::tactile
