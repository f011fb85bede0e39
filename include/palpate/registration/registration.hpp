// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "palpate/registration/gnc.hpp"
#include "palpate/registration/pose.hpp"

namespace palpate::registration {

/// How inliers are told from outliers.
enum class Method {
  kCliqueGnc,  ///< cliques of the consistency graph, GNC on those whose pairs do not all agree,
               ///< refined on all correspondences
  kGnc,        ///< GNC on all correspondences: the thesis' method, to about 80 % of outliers
};

struct RegistrationOptions {
  Method method = Method::kCliqueGnc;
  RobustCost cost = RobustCost::kTruncatedLeastSquares;  ///< of kGnc
  Primitive primitive = Primitive::kPoint;               ///< of the final refinement
  double noise_bound = 0.004;  ///< m, largest position error of an inlier: four standard deviations
  /// Noise of normals per tangent axis, deg, both frames' together; 0 leaves normals out of the
  /// search.
  double normal_noise_deg = 0;
  /// Consensus must be so good that wrong correspondences alone would propose fewer such poses. A
  /// large number, as 1000, accepts the best pose found even where chance explains it.
  double false_alarm = 0.01;
  std::uint64_t seed = 0;
  bool keep_history = false;  ///< of weights, kGnc

  template <class Visitor>
  void visit(Visitor&& v) {
    v("noise_bound", noise_bound, 1e-9, 1e9, "largest position error of an inlier, m");
    v("normal_noise_deg", normal_noise_deg, 0.0, 90.0,
      "noise of normals per tangent axis, deg; 0: normals are not used in the search");
    v("false_alarm", false_alarm, 1e-12, 1e12,
      "poses as good as the answer that chance may propose, per problem");
  }
};

struct RegistrationResult {
  Status status = Status::kNoConsensus;
  std::optional<Eigen::Isometry3d> T_target_source;  ///< none without consensus
  std::vector<int> inliers;                          ///< ascending
  std::vector<double> weights;                       ///< one a pair, 0..1
  std::vector<double> residuals;  ///< distances of points at the pose, m; empty without one
  double cost = 0;     ///< sum of squared residuals of the inliers, of the primitive, m^2
  double bound = 0;    ///< cost - least cost for these inliers is at most this, m^2
  int iterations = 0;  ///< poses tried (kCliqueGnc) or GNC iterations
  double expected_by_chance = 0;  ///< poses as good as this among wrong correspondences alone
  int rank = 0;                   ///< of the information matrix
  Matrix6d information = Matrix6d::Zero();  ///< of the inliers, of twists [w; v], target frame
  std::vector<GncIteration> history;        ///< if asked for, kGnc
  double search_seconds = 0, solve_seconds = 0, seconds = 0;  ///< rejection, final solve, all
};

/// Pose of source in target from correspondences most of which may be wrong, with what is known of
/// its quality.
///
/// Rejects outliers by point distances (thesis 6.2.1), then solves for the inliers with the chosen
/// primitive and certifies the optimum (thesis 6.2.2). The certificate speaks of the inliers found;
/// that these are no accident is what expected_by_chance says.
/// Fewer than three pairs, or inliers that leave a motion free (within the noise), are kDegenerate;
/// three that agree are kNoConsensus, as any three may.
/// @throws BadInput as check(), and for options out of range
RegistrationResult register_correspondences(const Correspondences& correspondences,
                                            const RegistrationOptions& options = {});

}  // namespace palpate::registration
