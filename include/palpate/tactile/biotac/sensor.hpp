// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "palpate/core/random.hpp"
#include "palpate/tactile/biotac/log.hpp"
#include "palpate/tactile/biotac/skin.hpp"

namespace palpate::tactile {

using hand::BiotacReading;
using hand::kPacSamples;
inline constexpr double kBiotacPeriod = 0.01;  ///< s between frames

/// Channels pdc, e1..e19, as a log has them.
BiotacChannels channels_of(const BiotacReading& reading);

/// Positions of the electrodes e1..e19 in the sensor frame, m, and their rest values, counts.
Eigen::Matrix<double, 3, kElectrodes> electrode_positions();
Eigen::Matrix<double, kElectrodes, 1> electrode_rest();

struct BiotacSensorOptions {
  double gap = 0.0019;           ///< m, between core and skin at rest
  double min_gap = 0.0002;       ///< m
  double spread = 0.0039;        ///< m, standard deviation of an electrode's view of the skin
  double bulge_area = 2.6e-4;    ///< m^2, of the skin that displaced fluid lifts
  double drag = 1.0;             ///< share of the skin's shear that drags fluid along
  double creep_share = 0.25;     ///< of the gap's change, that follows late ...
  double creep_time = 0.12;      ///< s, ... with this time constant
  double pressure_gain = 60;     ///< counts/N, of pdc
  double pressure_rest = 2410;   ///< counts
  double pac_gain = 8;           ///< counts per count of pdc in its band
  double conductivity = 0.02;    ///< 1/K, growth of the fluid's conductivity
  double temperature_gain = 40;  ///< counts/K, of tdc
  double heat_gain = 120;        ///< counts/(K cm^2), of tac
  double noise = 0.4;            ///< counts, of every channel, before rounding

  template <class Visitor>
  void visit(Visitor&& v) {
    v("gap", gap, 1e-4, 0.01, "m, distance between core and skin at rest");
    v("min_gap", min_gap, 1e-5, 0.01, "m, least distance between core and skin");
    v("spread", spread, 1e-4, 0.02, "m, standard deviation of an electrode's view of the skin");
    v("bulge_area", bulge_area, 1e-5, 1.0, "m^2, of the skin that displaced fluid lifts");
    v("drag", drag, 0.0, 10.0, "share of the skin's shear that drags the fluid along");
    v("creep_share", creep_share, 0.0, 1.0,
      "share of the change of the gap that follows with a delay");
    v("creep_time", creep_time, 1e-3, 10.0, "s, time constant of that delay");
    v("pressure_gain", pressure_gain, 0.0, 1e4, "counts/N, gain of pdc");
    v("pressure_rest", pressure_rest, 0.0, 4095.0, "counts, rest value of pdc");
    v("pac_gain", pac_gain, 0.0, 1e3, "gain of pac relative to pdc in its band");
    v("conductivity", conductivity, 0.0, 0.1, "1/K, growth of the fluid's conductivity");
    v("temperature_gain", temperature_gain, 0.0, 1e3, "counts/K, gain of tdc");
    v("heat_gain", heat_gain, 0.0, 1e4, "counts/(K cm^2), gain of tac");
    v("noise", noise, 0.0, 100.0, "counts, noise of every channel");
  }
};

/// Resistances between the electrodes and the references under a pressed skin.
///
/// g_i = g0 - d_i + b, with b = (displaced volume) / bulge_area so that fluid is conserved.
/// R_j = R_j0 sum_i w_ij g0 / g_i is the integral of ds/g over the skin before electrode j. Shear
/// drags fluid of height g0 along with the skin by u = -tau / k_t and changes the gap by -g0 div u.
class BiotacElectrodes {
 public:
  /// Keeps a reference: the skin must outlive the electrodes.
  BiotacElectrodes(const BiotacSkin& skin, const BiotacSensorOptions& options);

  /// R_j / R_j0 - 1 after a long time.
  [[nodiscard]] Eigen::VectorXd resistances(const SkinState& state) const;

 private:
  const BiotacSkin* skin_;
  double gap_, min_gap_, bulge_area_, drag_;
  Eigen::MatrixXd view_;                  // kElectrodes x kTaxels, rows sum to 1
  std::array<Eigen::MatrixXd, 3> slope_;  // of view_ along x, y, z; 1/m
};

/// The channels of a BioTac: counts = 4095 R_ref / (R_ref + R_j) for electrodes, pressure,
/// band-passed pressure, temperature and heat flow, with noise.
class BiotacSensor {
 public:
  /// Keeps a reference: the skin must outlive the sensor.
  BiotacSensor(const BiotacSkin& skin, const BiotacSensorOptions& options,
               const RandomStream& random);

  /// The next frame, 10 ms after the last. @param temperature  of the core, deg C
  BiotacReading step(const SkinState& state, double temperature = 30);

  /// What it shows at rest and 30 deg C, without noise.
  [[nodiscard]] BiotacReading rest() const;

  /// Back to rest at time 0, the noise again.
  void reset();
  /// As reset, with other noise.
  void reseed(const RandomStream& random);

 private:
  double counts(double value);
  void fill_pressure(double force, BiotacReading& reading);

  const BiotacSkin* skin_;
  BiotacElectrodes electrodes_;
  BiotacSensorOptions options_;
  RandomStream origin_, random_;
  Eigen::VectorXd late_;  // of the resistances' change
  double last_pressure_ = 0, high_ = 0, low_ = 0, last_input_ = 0;
  int frame_ = 0;
};

}  // namespace palpate::tactile
