// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "palpate/tactile/biotac/log.hpp"

namespace palpate::tactile {

struct BiotacNormalOptions {
  int centres = 1600;   ///< largest number of samples that the model keeps
  double length = 1.5;  ///< of the kernel, in root-mean-square features
  double linear = 1;    ///< weight of the linear kernel
  double noise = 0.03;  ///< variance of the normals' components, of the kernel's
  bool mirror = true;   ///< also learn every sample mirrored at the finger's middle plane
  double session = 1;   ///< deg, standard deviation that a recording's errors have in common
  double turning = 11;  ///< deg per root of a second, of the plate that is touched

  template <class Visitor>
  void visit(Visitor&& v) {
    v("centres", centres, 10, 5000, "number of samples that the model keeps at most");
    v("length", length, 0.01, 100.0,
      "length scale of the kernel, relative to the root-mean-square features");
    v("linear", linear, 0.0, 100.0, "weight of the linear kernel");
    v("noise", noise, 1e-6, 10.0, "variance of the normals' components, relative to the kernel");
    v("mirror", mirror, "also learn from every sample mirrored in the finger's median plane");
    v("session", session, 0.0, 90.0, "deg, error that all normals of one recording have in common");
    v("turning", turning, 0.01, 1e4, "deg per root second, change of the normal between frames");
  }
};

/// A contact normal that a BioTac senses.
struct BiotacNormal {
  Eigen::Vector3d n;   ///< outward unit normal of the object in the sensor's frame
  double sigma = 0;    ///< standard deviation per tangent axis in a new recording, rad
  double novelty = 0;  ///< 0: like what was learned .. 1: like nothing that was learned
};

/// A frame to learn from or to test with.
struct BiotacSample {
  BiotacChannels change;  ///< counts minus rest
  Eigen::Vector3d n;      ///< outward unit normal of the object in the sensor's frame
  BiotacChannels rest = BiotacChannels::Zero();  ///< counts
};

/// The same touch on the other side of the finger's middle plane, y = 0.
BiotacSample mirrored(const BiotacSample& sample);

/// The usable samples of a log with known normals.
std::vector<BiotacSample> biotac_samples(const BiotacLog& log);

/// Variance of a normal's error per tangent axis, as touches showed it that were not learned from:
/// floor + unlearned * v + light * (50 / p)^2, of the model's own variance v and the pressure p.
struct BiotacErrorModel {
  double floor = 0;      ///< rad^2
  double unlearned = 1;  ///< factor of the Gaussian process' variance
  double light = 0;      ///< rad^2 at a pressure of 50 counts

  /// @param unlearned_variance  of the Gaussian process, rad^2  @param pressure  change, counts
  [[nodiscard]] double variance(double unlearned_variance, double pressure) const;
};

/// Normal of a flat contact from pressure and electrodes: a Gaussian process (Rasmussen & Williams
/// 2006, eqs 2.25, 2.26) with a squared-exponential and a linear kernel.
///
/// Counts are turned into the electrodes' conductances first, which rest at other values in every
/// recording. Features are the log pressure, the electrodes' shares of their total change, and the
/// changes themselves, plain and compressed.
class BiotacNormalModel {
 public:
  /// Its error model is that of a Gaussian process alone, which is too small for touches that were
  /// not learned from; train_biotac_normal finds another.
  /// @throws BadInput for fewer than ten samples
  static BiotacNormalModel train(const std::vector<BiotacSample>& samples,
                                 const BiotacNormalOptions& options = {});

  /// @throws BadInput, naming the source, for bytes that are no such model of this version
  static BiotacNormalModel parse(std::string_view bytes, const std::string& source);
  [[nodiscard]] std::string bytes() const;

  /// What the Gaussian process predicts for one frame.
  struct Prediction {
    Eigen::Vector3d n;
    double variance = 0;  ///< of its own, per tangent axis, rad^2
    double novelty = 0;   ///< as BiotacNormal's
  };
  /// Of many frames. Nothing where a value is not finite or the change of the pressure is not above
  /// 0. @throws BadInput unless there are as many rests as changes
  [[nodiscard]] std::vector<std::optional<Prediction>> predict(
      const std::vector<BiotacChannels>& changes, const std::vector<BiotacChannels>& rests) const;

  /// From one frame alone. Nothing as for predict.
  [[nodiscard]] std::optional<BiotacNormal> estimate(
      const BiotacChannels& change, const BiotacChannels& rest,
      BiotacRest tracking = BiotacRest::whole_log) const;

  /// The normals of a log's usable frames.
  ///
  /// What a touch measures in one frame holds for its neighbours, as far as the normal does not
  /// turn between them (a random walk): from the whole log every frame is smoothed with those
  /// before and after it, causally with those before it (Rauch, Tung & Striebel 1965). The errors
  /// of a touch have too much in common to average out: the variance is the weighted mean of the
  /// frames', not less.
  /// @param signals  of biotac_signals with the same `tracking`
  [[nodiscard]] std::vector<std::optional<BiotacNormal>> track(const BiotacLog& log,
                                                               const BiotacSignals& signals,
                                                               BiotacRest tracking) const;

  /// The error model for rest values from the whole log, or causal ones.
  [[nodiscard]] const BiotacErrorModel& errors(BiotacRest tracking) const {
    return errors_[tracking == BiotacRest::causal];
  }
  void set_errors(BiotacRest tracking, const BiotacErrorModel& errors) {
    errors_[tracking == BiotacRest::causal] = errors;
  }

 private:
  BiotacNormalModel() = default;
  void prepare();
  [[nodiscard]] std::vector<Prediction> predict(const Eigen::MatrixXd& features) const;

  Eigen::VectorXd mean_, scale_;  // of the features
  Eigen::MatrixXd centres_;       // features x centres
  Eigen::MatrixXd weights_;       // centres x 3
  Eigen::VectorXd noise_;         // variance of each centre's normal, of the kernel's
  Eigen::Vector3d mean_normal_ = Eigen::Vector3d::Zero();
  double length_ = 0, linear_ = 0;
  double spread_ = 0;   // rms of a normal's component about its mean
  double session_ = 0;  // rad
  double turning_ = 0;  // rad per root of a second
  std::array<BiotacErrorModel, 2> errors_;
  Eigen::LLT<Eigen::MatrixXd> factor_;  // of the kernel's matrix with the noise
};

/// Errors at frames that a model did not learn from.
struct BiotacNormalErrors {
  std::vector<double> error_deg;
  std::vector<double> normalised;  ///< squared, by the stated variance; 2 on average if honest

  void add(const BiotacNormalErrors& more);
  /// Share within the stated 95 % interval.
  [[nodiscard]] double coverage_95() const;
};

/// The angle between two directions, deg.
double angle_between_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// A model of the logs, whose error model is fitted to touches left out: the logs are cut where
/// contact breaks, and every fold leaves a run of whole touches out. Frames of one touch are never
/// on both sides.
/// @throws BadInput for fewer than ten samples
BiotacNormalModel train_biotac_normal(const std::vector<BiotacLog>& logs,
                                      const BiotacNormalOptions& options = {}, int folds = 10);

/// Errors of the normals that a model tracks through a log with known normals.
BiotacNormalErrors evaluate_biotac_normal(const BiotacNormalModel& model, const BiotacLog& log,
                                          BiotacRest tracking = BiotacRest::whole_log);

/// Errors (deg) of single frames of touches that were left out, as train_biotac_normal leaves them.
std::vector<double> cross_validate_biotac_normal(const std::vector<BiotacLog>& logs,
                                                 const BiotacNormalOptions& options = {},
                                                 int folds = 10);

}  // namespace palpate::tactile
