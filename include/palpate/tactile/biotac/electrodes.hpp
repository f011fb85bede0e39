// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/tactile/biotac/normal.hpp"
#include "palpate/tactile/biotac/sensor.hpp"

namespace palpate::tactile {

using ElectrodeChanges = Eigen::Matrix<double, kElectrodes, 1>;

/// The simulated sensor's few parameters as a real one's log has them.
struct ElectrodeFit {
  SkinOptions skin;
  BiotacSensorOptions sensor;
  /// The log's normals are turned into the sensor frame by R_sensor_log, after y -> -y if mirrored.
  Eigen::Matrix3d R_sensor_log = Eigen::Matrix3d::Identity();
  bool mirrored = false;

  /// Changes (counts, kElectrodes x n) of the electrodes under flat contacts with the samples'
  /// normals and pressures, once they last.
  [[nodiscard]] Eigen::MatrixXd changes(const std::vector<BiotacSample>& contacts) const;
};

struct ElectrodeFitOptions {
  int samples = 200;   ///< at most so many, chosen at random
  double outlier = 3;  ///< standard deviations, from which on residuals count linearly
  std::uint64_t seed = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("samples", samples, 20, 100000, "number of samples that are fitted at most");
    v("outlier", outlier, 0.1, 100.0,
      "residual above which a sample counts linearly, standard deviations");
  }
};

/// Fits the skin's stiffness and crown, the electrodes' view, the area that bulges, and the turn of
/// the log's frame to what the electrodes showed, starting from the defaults. The log holds no
/// forces: the gain of pdc stays, and the stiffness is only known against it.
/// @throws BadInput for fewer than 20 samples
ElectrodeFit fit_electrodes(const std::vector<BiotacSample>& samples,
                            const ElectrodeFitOptions& options = {});

struct ElectrodeModelOptions {
  int centres = 400;    ///< largest number of samples that the model keeps
  double length = 1;    ///< of the kernel, in root-mean-square features
  double linear = 0.3;  ///< weight of the linear kernel
  double noise = 0.1;   ///< variance of what firm touches show, of the kernel's
  /// Of the median size of the changes from their own median, from which on residuals count
  /// linearly.
  double outlier = 0.3;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("centres", centres, 10, 5000, "number of samples that the model keeps at most");
    v("length", length, 0.01, 100.0,
      "length scale of the kernel, relative to the root-mean-square features");
    v("linear", linear, 0.0, 100.0, "weight of the linear kernel");
    v("noise", noise, 1e-6, 10.0, "noise variance of firm touches, relative to the kernel");
    v("outlier", outlier, 0.01, 1e6,
      "residual above which a sample counts linearly, relative to the median change");
  }
};

/// What a real BioTac's electrodes show under a flat contact: a Gaussian process (Rasmussen &
/// Williams 2006, eq. 2.25) on the normal and the root of the pressure, of the electrodes' changes
/// over the pressure.
///
/// A plate of one normal may touch the finger at several places, and then the electrodes show quite
/// different things: the model is fitted to least absolute residuals, by reweighted solutions
/// (Huber 1981, section 7.8). It learns from samples that cover normals and pressures evenly, for
/// the frames of a few long touches outnumber all others.
class ElectrodeModel {
 public:
  /// @throws BadInput for fewer than ten samples
  static ElectrodeModel train(const std::vector<BiotacSample>& samples,
                              const ElectrodeModelOptions& options = {});

  /// @throws BadInput, naming the source, for bytes that are no such model of this version
  static ElectrodeModel parse(std::string_view bytes, const std::string& source);
  [[nodiscard]] std::string bytes() const;

  /// Changes (counts) of the electrodes. @param n  outward unit normal of the object, as the log
  /// that was learned from has it @param pressure  change of pdc, counts, > 0
  /// @throws BadInput for a value that is not finite, or no pressure
  [[nodiscard]] ElectrodeChanges operator()(const Eigen::Vector3d& n, double pressure) const;

 private:
  Eigen::VectorXd mean_, scale_;       // of the features
  Eigen::MatrixXd centres_, weights_;  // features x centres, kElectrodes x centres
  ElectrodeChanges mean_change_;       // the medians, over the pressure
  double length_ = 0, linear_ = 0;
};

/// Mean absolute error of each electrode over its standard deviation, at samples that were not
/// learned from.
struct ElectrodeErrors {
  ElectrodeChanges fit;    ///< of fit_electrodes
  ElectrodeChanges model;  ///< of ElectrodeModel
};

/// Errors at `test` of what learns from `training`. @throws BadInput if either has too few
ElectrodeErrors evaluate_electrodes(const std::vector<BiotacSample>& training,
                                    const std::vector<BiotacSample>& test,
                                    const ElectrodeFitOptions& fit = {},
                                    const ElectrodeModelOptions& model = {});

/// As evaluate_electrodes, over folds that leave runs of whole touches out, as
/// cross_validate_biotac_normal does; nothing without two touches.
std::optional<ElectrodeErrors> cross_validate_electrodes(const std::vector<BiotacLog>& logs,
                                                         const ElectrodeFitOptions& fit = {},
                                                         const ElectrodeModelOptions& model = {},
                                                         int folds = 5);

}  // namespace palpate::tactile
