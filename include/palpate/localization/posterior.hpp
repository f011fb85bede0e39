// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string_view>
#include <vector>

#include "palpate/core/angle.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::localization {

/// Probability of the credible set.
inline constexpr double kCredible = 0.95;

/// A one-parameter family of credible poses: rotation about a line by -extent..+extent.
struct FreeAxis {
  Eigen::Vector3d point;      ///< on the line, in the evidence's frame, m
  Eigen::Vector3d direction;  ///< unit
  double extent = 0;          ///< rad, to either side of the mode's pose; pi: all round
  /// Share of the mode's weight that is within 5 deg and 10 mm of the mode's pose. Nothing where it
  /// is not known: all members then count as equally credible.
  std::optional<double> share = std::nullopt;
};

/// A cluster of credible poses.
struct Mode {
  Eigen::Isometry3d T_frame_object = Eigen::Isometry3d::Identity();
  double weight = 0;  ///< share of the posterior mass
  /// Of [rotation; translation], frame's axes; where there is a free axis, about the family.
  Matrix6d covariance = Matrix6d::Zero();
  std::optional<FreeAxis> free_axis;
};

enum class PoseStatus { certain, ambiguous, no_pose };
std::string_view to_string(PoseStatus status);

/// What is known of the object's pose: a few modes (LocalizerOptions::modes at most), heaviest
/// first, equal poses of a symmetric object counted once.
struct Posterior {
  PoseStatus status = PoseStatus::no_pose;
  std::vector<Mode> modes;
  /// The rest of the 95 % credible set where the modes hold less than that: centres of balls of
  /// 5 deg and 10 mm, heaviest first, or all that the samples form where those hold less, too.
  std::vector<Eigen::Isometry3d> residual_set;
  /// Posterior mass of the modes and the residual set together: 0.95 or more, or, where the samples
  /// hold less, a cautious estimate of what they hold; 0 without modes.
  double credible_mass = 0;
  double seconds = 0;  ///< wall time of the search

  /// Share of the posterior mass that is in none of the modes.
  double residual_mass() const;
};

struct PoseError {
  double rotation = 0;     ///< rad
  double translation = 0;  ///< of the volume centroid, m
};

/// How close two poses must be to count as the same. The default is that of the probability stated
/// for a pose.
struct PoseTolerance {
  double rotation = 0.0872664625997165;  ///< rad (5 deg)
  double translation = 0.010;            ///< m
};

/// How close a right pose is to the truth. The default tolerance has the same angle rounded to 15
/// digits; results can be repeated bit for bit only while both keep their values.
inline constexpr PoseTolerance kRightPose{5 * kDegree, 0.010};

/// True when both errors are below the tolerance.
bool within(const PoseError& error, const PoseTolerance& tolerance = kRightPose);

/// Distance of a pose from the truth, modulo the object's symmetries.
PoseError pose_error(const Eigen::Isometry3d& estimate, const Eigen::Isometry3d& truth,
                     const std::vector<Eigen::Matrix3d>& symmetries);

/// Least distance of any pose of the mode (along its free axis, if it has one) from the truth.
PoseError mode_error(const Mode& mode, const Eigen::Isometry3d& truth,
                     const std::vector<Eigen::Matrix3d>& symmetries);

/// Covariance of all poses of a mode, [rotation; translation], with an even spread along its free
/// axis: at +-180 deg the variance of that turn is pi^2 / 3.
Matrix6d family_covariance(const Mode& mode);

/// The probability stated for the pose of a mode itself: that the object is within 5 deg and 10 mm
/// of it, modulo its symmetries. Of a family about a free axis that is the share of its weight
/// there.
double pose_probability(const Mode& mode);

/// That of the best pose; 0 where there is none.
double best_probability(const Posterior& posterior);

/// The posterior where what it is conditioned on, such as which object it is, has this probability:
/// all weights times that.
Posterior weighted(Posterior posterior, double probability);

/// True when the truth is within 5 deg and 10 mm of the smallest set of modes that holds 95 % of
/// the probability, or of all modes where they hold less.
bool covers(const Posterior& posterior, const Eigen::Isometry3d& truth,
            const std::vector<Eigen::Matrix3d>& symmetries);

/// The same with the residual set, which may be large.
bool truth_in_credible_set(const Posterior& posterior, const Eigen::Isometry3d& truth,
                           const std::vector<Eigen::Matrix3d>& symmetries);

}  // namespace palpate::localization
