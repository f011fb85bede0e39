// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "palpate/tactile/biotac/log.hpp"

namespace palpate::tactile {

struct BiotacNormalOptions {
  int centres = 900;    ///< at most so many samples carry the model
  double length = 1.5;  ///< of the kernel, in root-mean-square features
  double linear = 0.3;  ///< weight of the linear kernel
  double noise = 0.03;  ///< variance of the normals' components, of the kernel's
  bool mirror = true;   ///< also learn every sample mirrored at the finger's middle plane
  std::uint64_t seed = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("centres", centres, 10, 5000, "at most so many samples carry the model");
    v("length", length, 0.01, 100.0, "of the kernel, in root-mean-square features");
    v("linear", linear, 0.0, 100.0, "weight of the linear kernel");
    v("noise", noise, 1e-6, 10.0, "variance of the normals' components, relative to the kernel");
    v("mirror", mirror, "also learn every sample mirrored at the finger's middle plane");
  }
};

/// A contact normal felt by a BioTac.
struct BiotacNormal {
  Eigen::Vector3d n;   ///< outward unit normal of the object in the sensor's frame
  double sigma = 0;    ///< standard deviation per tangent axis, rad
  double novelty = 0;  ///< 0: like what was learned .. 1: like nothing that was learned
};

/// One touch to learn from.
struct BiotacSample {
  BiotacChannels change;  ///< counts minus rest
  Eigen::Vector3d n;      ///< outward unit normal of the object in the sensor's frame
};

/// The usable samples of a log with known normals.
std::vector<BiotacSample> biotac_samples(const BiotacLog& log);

/// Normal of a flat contact from pressure and electrodes: a Gaussian process (Rasmussen & Williams
/// 2006, eqs 2.25, 2.26) on the log pressure, the electrodes' shares of their total change, and the
/// changes themselves, with a squared-exponential and a linear kernel.
class BiotacNormalModel {
 public:
  /// @throws BadInput for fewer than ten samples
  static BiotacNormalModel train(const std::vector<BiotacSample>& samples,
                                 const BiotacNormalOptions& options = {});

  /// @throws BadInput, naming the source, for bytes that are no such model of this version
  static BiotacNormalModel parse(std::string_view bytes, const std::string& source);
  [[nodiscard]] std::string bytes() const;

  /// Nothing where a change is not finite or the pressure's is not above 0.
  [[nodiscard]] std::optional<BiotacNormal> estimate(const BiotacChannels& change) const;

 private:
  BiotacNormalModel() = default;
  void prepare();

  Eigen::VectorXd mean_, scale_;  // of the features
  Eigen::MatrixXd centres_;       // features x centres
  Eigen::MatrixXd weights_;       // centres x 3
  Eigen::Vector3d mean_normal_ = Eigen::Vector3d::Zero();
  double length_ = 0, linear_ = 0, noise_ = 0;
  double spread_ = 0;     // rms of a normal's component about its mean
  double residual_ = 0;   // rad, per tangent axis, where much was learned
  Eigen::MatrixXd root_;  // inverse Cholesky factor of the kernel's matrix
};

/// The angle between two directions, deg.
double angle_between_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// Errors (deg) at samples that the model did not learn from: the logs' touches are cut where
/// contact breaks, and every fold leaves a run of whole touches out. Frames of one touch are never
/// on both sides.
std::vector<double> cross_validate_biotac_normal(const std::vector<BiotacLog>& logs,
                                                 const BiotacNormalOptions& options = {},
                                                 int folds = 5);

}  // namespace palpate::tactile
