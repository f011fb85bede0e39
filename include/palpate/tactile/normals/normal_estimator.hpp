// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/tactile/contacts/finger_sample.hpp"

namespace palpate::tactile {

enum class NormalStatus {
  none,     ///< no estimate yet; the normal is nan
  tracked,  ///< follows the contact
  held,     ///< the sample was of no use: the last estimate
};
std::string_view to_string(NormalStatus status);

/// What is known of the object's surface at the contact.
struct NormalEstimate {
  double time = 0;  ///< s, of the contact that it describes
  NormalStatus status = NormalStatus::none;
  Eigen::Vector3d n =
      Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());  ///< outward unit normal
  /// Of n, rad^2, zero along n; only from estimators that have one.
  std::optional<Eigen::Matrix3d> covariance;
};

/// Follows the normal under one fingertip through its samples, in the order of time.
class NormalEstimator {
 public:
  virtual ~NormalEstimator() = default;

  /// Takes the next sample. One that is not usable leaves the estimate as it is (held); after a
  /// lift (a contact that ended, or a gap in which the finger may have left the surface) the
  /// estimator starts again. Only the filters on the sphere grow less certain of an estimate that
  /// they hold.
  virtual NormalEstimate update(const FingerSample& sample) = 0;

  /// Estimates of contacts that wait for later samples which will not come, because the contact or
  /// the log has ended; in the order of time, each once. Call it after every update() and, with
  /// `ended`, after the last one.
  virtual std::vector<NormalEstimate> take_late([[maybe_unused]] bool ended = false) { return {}; }
};

/// Names of all estimators: "rls", "rls-literal", "tls", "eigen", "s2", "s2-lag".
const std::vector<std::string>& normal_estimators();

/// An estimator by its name, with its own default options.
/// @throws BadInput for an unknown name
std::unique_ptr<NormalEstimator> make_normal_estimator(std::string_view name);

}  // namespace palpate::tactile
