// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "palpate/registration/free_motions.hpp"
#include "palpate/registration/rotation.hpp"

namespace palpate::registration {

/// What is proven of a pose for given correspondences.
enum class Status {
  kCertified,    ///< proven to minimise the sum of squared residuals globally
  kUncertified,  ///< not proven; the bound says how far it may be from the minimum
  kDegenerate,   ///< the correspondences leave a direction of motion free
};

/// "certified", "uncertified" or "degenerate".
std::string_view to_string(Status status);

/// The rotations among which a pose is looked for; its shift is always free.
struct AllowedTurns {
  std::optional<Eigen::Vector3d> axis = std::nullopt;  ///< those about it alone, as gravity; not 0
  bool none = false;                                   ///< the identity alone

  bool all() const { return !axis && !none; }
};

struct PoseOptions {
  RotationOptions rotation;
  /// A direction of motion (lever arms over their root mean square, so that turning and shifting
  /// compare) is free if its share of the information of one residual a pair is below this.
  double rank_tolerance = 1e-6;
};

struct PoseEstimate {
  Status status = Status::kDegenerate;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  double cost = 0;       ///< sum of weighted squared residuals, m^2
  double bound = 0;      ///< cost - least cost is at most this, m^2
  double reference = 0;  ///< max(cost, tr(Q~)/10), what the bound is small against, m^2
  int rank = 0;          ///< of the information matrix, 0..6; motions that are not allowed count
  Matrix6d information = Matrix6d::Zero();  ///< at the pose, of twists [w; v] in the target frame
  /// The same about the points' centre, in digits that do not depend on how far off that is.
  Matrix6d centred_information = Matrix6d::Zero();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< m, target frame
  std::vector<FreeMotion> free_motions;              ///< 6 - rank of them
};

/// Pose that minimises the sum of weighted squared residuals, with its certificate.
///
/// Thesis Algorithm 3 on centred coordinates.
/// @param weights  >= 0, one a pair, or empty for all 1
/// @throws BadInput as check(), and for weights of another number, negative or not finite
PoseEstimate solve_pose(const Correspondences& correspondences, const std::vector<double>& weights,
                        Primitive primitive, const PoseOptions& options = {});

/// What is proven of anyone's pose: its cost against the least cost that can be proven.
/// @return status kCertified if the bound is at most options.rotation.relative_gap of `reference`
/// @throws BadInput as solve_pose(), and unless the pose is a rigid motion to 1e-6
PoseEstimate certify(const Eigen::Isometry3d& T_target_source,
                     const Correspondences& correspondences, const std::vector<double>& weights,
                     Primitive primitive, const PoseOptions& options = {});

/// Pose that minimises the sum of weighted squared distances of points, in closed form (Kabsch
/// 1978, Umeyama 1991); a rotation, never a reflection. The identity if all weights are 0.
Eigen::Isometry3d align_points(const Correspondences& correspondences,
                               const std::vector<double>& weights);

/// solve_pose() among the allowed turns, the best of them all: about an axis the cost is a
/// trigonometric polynomial of second degree of the angle, without turns it is quadratic. The free
/// motions are those that the limits leave.
PoseEstimate solve_pose(const Correspondences& correspondences, const std::vector<double>& weights,
                        Primitive primitive, const AllowedTurns& turns,
                        const PoseOptions& options = {});

/// align_points() among the allowed turns.
Eigen::Isometry3d align_points(const Correspondences& correspondences,
                               const std::vector<double>& weights, const AllowedTurns& turns);

}  // namespace palpate::registration
