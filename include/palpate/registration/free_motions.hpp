// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "palpate/core/se3.hpp"

namespace palpate::registration {

/// A motion of the source that the residuals do not notice, in the target's frame.
struct FreeMotion {
  enum class Kind { kRotation, kTranslation, kScrew, kScaling };

  Kind kind = Kind::kTranslation;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< of the axis or shift, unit
  /// m, on the axis; of a shift the centre, of a scaling the point that stays
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  double pitch = 0;  ///< m/rad, of a screw
};

/// "rotation", "translation", "screw" or "scaling", where the scale is unknown, too.
std::string_view to_string(FreeMotion::Kind kind);

/// What residuals determine of a motion about their centre.
struct CentredInformation {
  Matrix6d information = Matrix6d::Zero();           ///< J'WJ of twists [w; v] about the centre
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< m, target frame
  double squared_arm =
      0;  ///< m^2, mean square of the points' distances to the centre; 0: one point
  double weight_sum = 0;
};

/// Treats turns that are not allowed as if each had the whole information: what is free after it is
/// free among the others.
void exclude_turns(CentredInformation& about, const Eigen::Matrix3d& excluded);

/// Directions of motion that are free: those with less than `tolerance` of the information that one
/// unit residual a pair gives, lever arms in units of their root mean square so that turning and
/// shifting compare. Shifts first, then axes at right angles to them.
std::vector<FreeMotion> free_motions(const CentredInformation& information, double tolerance);

}  // namespace palpate::registration
