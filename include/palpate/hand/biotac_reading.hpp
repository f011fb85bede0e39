// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

namespace palpate::hand {

inline constexpr int kElectrodes = 19;            ///< of a BioTac, e1..e19
inline constexpr double kBiotacFullScale = 4095;  ///< counts, of every channel
inline constexpr int kPacSamples = 22;            ///< of each frame of 10 ms: 2.2 kHz

/// One frame of a BioTac: 12-bit counts; nan where a channel is missing.
struct BiotacReading {
  double time = 0;  ///< s
  double pdc = 0, tdc = 0, tac = 0;
  std::array<double, kPacSamples> pac{};
  /// The pressure was known only at the frames and interpolated between them for `pac`.
  bool pac_interpolated = true;
  Eigen::Matrix<double, kElectrodes, 1> electrodes = Eigen::Matrix<double, kElectrodes, 1>::Zero();
};

}  // namespace palpate::hand
