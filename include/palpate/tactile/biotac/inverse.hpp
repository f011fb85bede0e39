// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/numerics/mlp.hpp"
#include "palpate/tactile/biotac/dataset.hpp"

namespace palpate::tactile {

/// A contact inferred from channels alone, in the sensor frame.
struct InferredContact {
  Eigen::Vector3d p;  ///< point on the skin, m
  Eigen::Vector3d n;  ///< outward unit normal of the object: against the skin's at p
  Eigen::Vector3d f;  ///< force on the object, N
  /// Of the point in the skin's tangent plane and the force: [u v fu fv fn], m and N, along the
  /// columns of `tangents` and the skin's outward normal. Diagonal: of how the errors go together
  /// it states nothing. On simulated touches 0.90 of the errors lie within two standard deviations,
  /// where Gaussian ones would be 0.95.
  Eigen::Matrix<double, 5, 5> covariance;
  Eigen::Matrix3d tangents;  ///< columns u, v and the skin's outward normal at p
  double misfit = 0;         ///< root mean square residual of the channels, standard deviations
};

/// True minus inferred [u v fu fv fn], as the covariance has it.
Eigen::Matrix<double, 5, 1> contact_error(const InferredContact& found, const Eigen::Vector3d& p,
                                          const Eigen::Vector3d& f);

struct BiotacInverseOptions {
  int hidden = 48;     ///< units in each of the two hidden layers of the first guess
  int epochs = 30;     ///< passes over the data
  double rate = 2e-3;  ///< of numerics::Adam, at the start
  std::uint64_t seed = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("hidden", hidden, 1, 4096, "number of units in each of the two hidden layers");
    v("epochs", epochs, 1, 100000, "number of passes over the data");
    v("rate", rate, 1e-7, 1.0, "initial learning rate of Adam");
  }
};

/// Contact point, normal and force (the "skew force") from a BioTac's channels.
///
/// A small network guesses; then the contact's place, force and the object's curvature are fitted
/// to the channels through the skin's model (Levenberg 1944, Marquardt 1963). The variances
/// follow from the fit's own, its misfit and the pressure, as errors did on trajectories that the
/// network has not learned.
class BiotacInverse {
 public:
  /// Pressure change, counts, up to which nothing is inferred.
  static constexpr double kMinPressure = 8;

  /// @throws BadInput for too few trajectories, or frames without contact only
  static BiotacInverse train(const std::vector<BiotacFrame>& frames,
                             const BiotacInverseOptions& options = {}, const SkinOptions& skin = {},
                             const BiotacSensorOptions& sensor = {});

  /// @throws BadInput, naming the source, for bytes that are no such model of this version
  static BiotacInverse parse(std::string_view bytes, const std::string& source);
  [[nodiscard]] std::string bytes() const;

  [[nodiscard]] const BiotacSensorOptions& sensor() const { return sensor_options_; }

  /// Nothing where the pressure shows no contact.
  [[nodiscard]] std::optional<InferredContact> estimate(const DecodedReading& reading) const;

 private:
  struct Unknowns;
  BiotacInverse(const SkinOptions& skin, const BiotacSensorOptions& sensor, numerics::Mlp guess);
  [[nodiscard]] Eigen::MatrixXd standardised(const Eigen::MatrixXd& inputs) const;
  [[nodiscard]] Eigen::VectorXd residuals(const Unknowns& unknowns, const DecodedReading& reading,
                                          const Eigen::VectorXd& sigma) const;
  [[nodiscard]] Unknowns guess(const DecodedReading& reading) const;
  [[nodiscard]] InferredContact fit(const DecodedReading& reading) const;
  void calibrate(const std::vector<BiotacFrame>& held_out);

  SkinOptions skin_options_;
  BiotacSensorOptions sensor_options_;
  std::shared_ptr<const BiotacSkin> skin_;  // which the electrodes refer to
  BiotacElectrodes electrodes_;
  numerics::Mlp guess_;
  Eigen::VectorXd input_mean_, input_sd_, output_mean_, output_sd_;
  /// Of the logarithm of each variance: 1, and the logarithms of the fit's own, misfit, pressure.
  Eigen::Matrix<double, 4, 5> calibration_ = Eigen::Vector4d(0, 1, 0, 0).replicate<1, 5>();
};

}  // namespace palpate::tactile
