// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "palpate/registration/gnc.hpp"
#include "palpate/registration/pose.hpp"
#include "palpate/registration/robust_bound.hpp"

namespace palpate::registration {

/// How inliers are distinguished from outliers.
enum class Method {
  kCliqueGnc,  ///< cliques of the consistency graph, GNC on those whose pairs do not all agree,
               ///< refined on all correspondences
  kGnc,        ///< GNC on all correspondences: the thesis' method, to about 80 % of outliers
};

/// Whether there is an answer. How good it is stands in the certificate, apart from this.
enum class RegistrationStatus {
  kFound,        ///< a consensus that wrong correspondences alone do not explain
  kNoConsensus,  ///< so few agree with any pose that wrong correspondences explain them
  kDegenerate,   ///< the correspondences, or the surface, leave a direction of motion free
};

/// "found", "no_consensus" or "degenerate".
std::string_view to_string(RegistrationStatus status);

struct RegistrationOptions {
  Method method = Method::kCliqueGnc;
  RobustCost cost = RobustCost::kTruncatedLeastSquares;  ///< of kGnc
  Primitive primitive = Primitive::kPoint;               ///< of the final refinement
  double noise_bound = 0.004;  ///< m, largest position error of an inlier: four standard deviations
  /// Noise of normals per tangent axis, deg, both frames' together; 0 leaves normals out of the
  /// search.
  double normal_noise_deg = 0;
  /// Consensus must be so good that wrong correspondences alone would propose fewer such poses.
  double max_false_alarms = 0.01;
  /// Give the best pose found, even of three pairs, where wrong correspondences explain it too; its
  /// false_alarms say so.
  bool best_effort = false;
  /// Pairs that lie within this of each other in both frames, m, may owe their agreement to one
  /// another, as matches of overlapping features do; 0: four noise bounds.
  double support_radius = 0;
  /// Start: the search is left out, inliers and pose take turns from here, with the bound
  /// narrowing from `initial_reach`.
  std::optional<Eigen::Isometry3d> initial = std::nullopt;
  double initial_reach = 8;  ///< noise bounds
  /// Direction in both frames about which alone the source may be turned (gravity); any length.
  std::optional<Eigen::Vector3d> rotation_axis = std::nullopt;
  bool translation_only = false;  ///< both frames are turned alike: shift the source, no more
  /// Solve for the scale of the source too (register_scaled()).
  bool estimate_scale = false;
  /// Poses looked for, each among the pairs that the ones before leave over: those farther than
  /// three noise bounds off.
  int instances = 1;
  RobustBoundOptions robust_bound = {};  ///< of the certificate; asked for by max_nodes
  std::uint64_t seed = 0;
  bool keep_history = false;  ///< of weights, kGnc

  AllowedTurns turns() const { return {rotation_axis, translation_only}; }

  template <class Visitor>
  void visit(Visitor&& v) {
    v("noise_bound", noise_bound, 1e-9, 1e9, "largest position error of an inlier, m");
    v("normal_noise_deg", normal_noise_deg, 0.0, 90.0,
      "noise of normals per tangent axis, deg; 0: normals are not used in the search");
    v("max_false_alarms", max_false_alarms, 1e-12, 1e12,
      "poses as good as the answer that wrong pairs alone may propose, per problem");
    v("best_effort", best_effort, "give the best pose found even where wrong pairs explain it");
    v("support_radius", support_radius, 0.0, 1e9,
      "pairs within this of each other in both frames may depend on one another, m; 0: four noise "
      "bounds");
    v("initial_reach", initial_reach, 1.0, 1e6,
      "noise bounds within which pairs count at first, from an initial pose");
    v.section("robust_bound", robust_bound);
  }
};

/// Another pose that many pairs agree with, all of them outliers of the answer.
struct RunnerUp {
  int inliers = 0;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  double false_alarms = 0;
};

/// What is proven of the answer, two things apart. That there is a consensus at all is what
/// `false_alarms` says; no proof is needed for that, and none follows from these.
struct RegistrationCertificate {
  /// No pose has a smaller sum of squared residuals over the chosen inliers. In closed form for
  /// points, where it always holds; for planes by the dual.
  bool least_squares = false;
  /// A better pose for these inliers, nearby, is within this angle, deg: sqrt(bound / least
  /// information of a turn).
  double resolution_deg = 0;
  /// No pose at all has more inliers than this; nothing if it was not asked for.
  std::optional<RobustBound> robust = std::nullopt;
};

struct RegistrationResult {
  RegistrationStatus status = RegistrationStatus::kNoConsensus;
  std::optional<Eigen::Isometry3d> T_target_source;  ///< of kFound alone
  double scale = 1;               ///< the target is T_target_source of scale times the source
  std::vector<int> inliers;       ///< ascending
  std::vector<double> weights;    ///< one a pair, 0..1
  std::vector<double> residuals;  ///< distances of points at the pose, m; empty without one
  double cost = 0;     ///< sum of squared residuals of the inliers, of the primitive, m^2
  double bound = 0;    ///< cost - least cost for these inliers is at most this, m^2
  int iterations = 0;  ///< poses tried (kCliqueGnc) or GNC iterations
  /// Expected poses as good as this among wrong correspondences alone; 1, not estimated, of clouds
  /// from an initial pose.
  double false_alarms = 0;
  RegistrationCertificate certificate;
  std::optional<RunnerUp> runner_up;  ///< largest other consensus that came up
  std::vector<RunnerUp> instances;    ///< further poses, largest first, if asked for
  /// More pairs agree with a mirror image than with any rigid motion: such an answer is refused.
  bool mirrored = false;
  /// Of the inliers, wrong pairs that agree by accident, as expected from the same points paired
  /// otherwise.
  double false_inliers = 0;
  int rank = 0;                             ///< of the information matrix
  std::vector<FreeMotion> free_motions;     ///< of kDegenerate
  Matrix6d information = Matrix6d::Zero();  ///< of the inliers, of twists [w; v], target frame
  /// Of twists [w; v] in the target frame, rad and m, 0 along those not allowed: the inverse
  /// information times the residuals' variance, estimated from the inliers, over the squared share
  /// of them that are right. Pairs that agree by accident add to the information what the cut at
  /// the bound takes away again. Unequal weights do not change the noise that is supposed of a
  /// pair: I^-1 (sum w^2 J'J) I^-1 takes the place of the inverse information. Of refined clouds,
  /// whose residuals depend on one another, times `normal_neighbours` and by how much the variance
  /// within the whole bound exceeds that within the last one.
  Matrix6d covariance = Matrix6d::Zero();
  std::vector<GncIteration> history;                          ///< if asked for, kGnc
  double search_seconds = 0, solve_seconds = 0, seconds = 0;  ///< rejection, final solve, all
};

/// @throws BadInput for options out of range or that exclude one another
void check(const RegistrationOptions& options);

/// Pose of source in target from correspondences most of which may be wrong, with what is known of
/// its quality.
///
/// Rejects outliers by point distances (thesis 6.2.1), then solves for the inliers with the chosen
/// primitive and certifies the optimum (thesis 6.2.2). The pose is that of the largest consensus:
/// the search goes on until one of more inliers would have come up. The certificate speaks of the
/// inliers found; that these are no accident is what false_alarms says.
/// Fewer than three pairs, or inliers that leave a motion free (within the noise), are kDegenerate;
/// three that agree are kNoConsensus, as any three may, unless best_effort is set.
/// @throws BadInput as check(), and for options out of range or that exclude one another
RegistrationResult register_correspondences(const Correspondences& correspondences,
                                            const RegistrationOptions& options = {});

}  // namespace palpate::registration
