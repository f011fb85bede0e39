// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/touch/biotac_sensor.hpp"

namespace palpate::touch {

/// What the electrodes' counts say of the skin: R_j / R_j0 - 1 after a long time, and the pressure.
struct DecodedReading {
  Eigen::VectorXd resistances;  ///< kElectrodes relative changes, freed of temperature and creep
  double pressure = 0;          ///< change of pdc, counts
};

/// Takes temperature and creep out of a sensor's readings, frame by frame. The creep is linear in
/// the resistances, so that its state follows from the readings alone.
class BiotacDecoder {
 public:
  /// @param rest  a reading at rest
  BiotacDecoder(const BiotacReading& rest, const BiotacSensorOptions& sensor);

  /// Another reading at rest, for what has drifted.
  void set_rest(const BiotacReading& rest) { rest_ = rest; }

  /// The next frame, 10 ms after the last; nothing where a channel is not finite, outside 0..4095
  /// or at an end of that range.
  std::optional<DecodedReading> step(const BiotacReading& reading);

 private:
  BiotacReading rest_;
  BiotacSensorOptions sensor_;
  Eigen::VectorXd late_;
};

}  // namespace palpate::touch
