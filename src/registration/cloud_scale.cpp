// SPDX-License-Identifier: Apache-2.0
#include "registration/cloud_scale.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "palpate/core/se3.hpp"
#include "registration/clock.hpp"
#include "registration/cloud_refinement.hpp"
#include "registration/limited_rotation.hpp"
#include "registration/neighbour_rounds.hpp"
#include "registration/surface_motions.hpp"

namespace palpate::registration {
namespace {

using geometry::PointCloud;

/// Cells of the source's grid and of the target's, in units of those that leave max_points.
struct Grids {
  double source, target;
};
constexpr std::array kGrids = {Grids{1, 1}, Grids{1.41, 1}, Grids{1, 1.41}, Grids{2, 1},
                               Grids{1, 2}};
constexpr int kScalesAGrid = 5;  // that register_correspondences() tries

PointCloud scaled(PointCloud cloud, double scale) {
  for (auto& p : cloud.points) p *= scale;
  return cloud;
}

struct Proposal {
  double scale = 1, false_alarms = std::numeric_limits<double>::infinity();
};

/// Scale of the matches, with the source's normals of either sign.
Proposal scale_of_matches(FeatureCloud from, const FeatureCloud& to, double cell,
                          const CloudOptions& options) {
  RegistrationOptions search = options.registration;
  search.noise_bound = options.noise_bound.value_or(1.5 * cell);
  search.primitive = Primitive::kPoint;
  search.robust_bound.max_nodes = 0;
  search.support_radius =
      std::max(search.support_radius, options.features.feature_radius_voxels * cell);
  Proposal best;
  for (int attempt = 0; attempt < (from.estimated_normals || to.estimated_normals ? 2 : 1);
       ++attempt) {
    if (attempt > 0) from.features = geometry::turned_inside_out(std::move(from.features));
    const RegistrationResult found =
        register_correspondences(matched_features(from, to, options.threads), search);
    if (found.T_target_source && found.false_alarms < best.false_alarms) {
      best = {found.scale, found.false_alarms};
    }
  }
  return best;
}

/// @return false alarms as expected of all scales tried; infinitely many without any
Proposal propose_scale(const PointCloud& source, const PointCloud& target,
                       const CloudOptions& options) {
  constexpr double kClearFalseAlarms = 1e-12;
  const auto cell_of = [&](const PointCloud& cloud) {
    return suggested_voxel(cloud, cloud, options.features.max_points, options.threads);
  };
  const double source_cell = cell_of(source);
  const double target_cell = options.features.voxel > 0 ? options.features.voxel : cell_of(target);
  Proposal best;
  if (!(source_cell > 0 && target_cell > 0)) return best;
  for (const Grids& grids : kGrids) {
    const double cell = grids.target * target_cell;
    const FeatureCloud from = describe(source, grids.source * source_cell, options.features,
                                       options.threads),
                       to = describe(target, cell, options.features, options.threads);
    if (std::min(from.cloud.size(), to.cloud.size()) < 4) continue;
    const Proposal next = scale_of_matches(from, to, cell, options);
    if (next.false_alarms < best.false_alarms) best = next;
    if (best.false_alarms < kClearFalseAlarms) break;
  }
  return best;
}

/// Normal equations of the pairs' residuals for an allowed twist about `center` and the logarithm
/// of the scale, which comes last.
struct SimilarityEquations {
  Eigen::MatrixXd information;
  Eigen::VectorXd right_side;
  Eigen::Vector3d center;
  double squared_arm = 0;  // mean square, m^2
};

SimilarityEquations similarity_equations(const CloudRegistration& registration,
                                         const RegistrationOptions& options) {
  const Correspondences& pairs = registration.correspondences;
  const Eigen::Isometry3d& T = *registration.result.T_target_source;
  const auto twists = allowed_twists(options.turns());
  const Eigen::Index unknowns = twists.cols() + 1;
  SimilarityEquations equations{Eigen::MatrixXd::Zero(unknowns, unknowns),
                                Eigen::VectorXd::Zero(unknowns),
                                T * weighted_means(pairs, {}).source};
  const auto add = [&](const Eigen::Vector3d& arm, const Eigen::Vector3d& off,
                       const Eigen::Vector3d& direction) {
    Vector6d row;
    row << arm.cross(direction), direction;
    Eigen::VectorXd all(unknowns);
    all << twists.transpose() * row, arm.dot(direction);
    equations.information.noalias() += all * all.transpose();
    equations.right_side += off.dot(direction) * all;
  };
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d at = T * pairs.source[i], arm = at - equations.center;
    equations.squared_arm += arm.squaredNorm() / static_cast<double>(pairs.size());
    if (options.primitive == Primitive::kPlane) {
      add(arm, pairs.target[i] - at, pairs.target_normals[i]);
    } else {
      for (int k = 0; k < 3; ++k) add(arm, pairs.target[i] - at, Eigen::Vector3d::Unit(k));
    }
  }
  return equations;
}

/// The point that a scaling leaves where it is, if the pairs do not notice it.
std::optional<FreeMotion> free_scaling(const SimilarityEquations& equations, std::size_t pairs,
                                       const AllowedTurns& turns) {
  // Edges that plane fits round off gave a thousandth; ten generated shapes have at least a
  // quarter.
  constexpr double kMinShare = 0.02;
  const Eigen::Index motions = equations.information.rows() - 1;
  const auto cross = equations.information.topRightCorner(motions, 1);
  const Eigen::VectorXd follow =
      equations.information.topLeftCorner(motions, motions).ldlt().solve(cross);
  const double left = equations.information(motions, motions) - cross.col(0).dot(follow);
  if (left > kMinShare * equations.squared_arm * static_cast<double>(pairs)) return std::nullopt;
  FreeMotion motion{.kind = FreeMotion::Kind::kScaling};
  const Vector6d twist = allowed_twists(turns) * follow;
  // An arm a moves by a - w x a - v in the units of the scale's logarithm: by nothing at this one.
  const Eigen::Matrix3d moves = Eigen::Matrix3d::Identity() - skew(twist.head<3>());
  motion.point = equations.center + moves.inverse() * twist.tail<3>();
  return motion;
}

/// A step of scale and pose together.
/// @return the factor of the scale
double step(const SimilarityEquations& equations, const AllowedTurns& turns, Eigen::Isometry3d& T) {
  const Eigen::VectorXd solution = equations.information.ldlt().solve(equations.right_side);
  const Eigen::Index motions = solution.size() - 1;
  const Vector6d twist = allowed_twists(turns) * solution.head(motions);
  const double factor = std::exp(solution[motions]);
  const Eigen::Matrix3d R = exp_so3(twist.head<3>());
  const Eigen::Vector3d arm = T.translation() - equations.center;
  T.translation() = equations.center + factor * (R * arm) + twist.tail<3>();
  T.linear() = R * T.linear();
  return factor;
}

void withdraw(RegistrationStatus status, RegistrationResult& result) {
  result.status = status;
  result.T_target_source.reset();
  result.runner_up.reset();
  result.residuals.clear();
}

/// Scale and pose in turn from a registration at a scale, until the scale stays.
/// @param source, target  with normals
CloudRegistration refine_scale(CloudRegistration registration, const PointCloud& source,
                               const PointCloud& target, CloudOptions options) {
  constexpr int kRounds = 20;
  constexpr double kSettled = 1e-5, kMaxChange = 1.25;
  const AllowedTurns turns = options.registration.turns();
  const double first = registration.result.scale;
  options.noise_bound = registration.noise_bound;
  options.features.voxel = registration.voxel;
  for (int round = 0; round < kRounds && registration.result.T_target_source; ++round) {
    const auto equations = similarity_equations(registration, options.registration);
    if (const auto free = free_scaling(equations, registration.correspondences.size(), turns)) {
      withdraw(RegistrationStatus::kDegenerate, registration.result);
      registration.result.free_motions = {*free};
      break;
    }
    Eigen::Isometry3d T = *registration.result.T_target_source;
    const double factor = step(equations, turns, T), scale = factor * registration.result.scale;
    if (!(std::max(scale / first, first / scale) < kMaxChange)) {
      withdraw(RegistrationStatus::kNoConsensus, registration.result);
      break;
    }
    options.registration.initial = T;
    CloudRegistration next = register_clouds(scaled(source, scale), target, options);
    next.result.scale = scale;
    next.result.false_alarms = registration.result.false_alarms;
    next.result.certificate.robust = registration.result.certificate.robust;
    next.feature_matches = registration.feature_matches;
    next.feature_inliers = registration.feature_inliers;
    next.feature_seconds = registration.feature_seconds;
    registration = std::move(next);
    if (std::abs(factor - 1) < kSettled) break;
  }
  return registration;
}

/// A surface that slides along itself matches at no scale. That a scene seems to, of things that
/// lie far from one another, says nothing: the source decides.
void report_sliding(const PointCloud& source, const PointCloud& target, const AllowedTurns& turns,
                    RegistrationResult& result) {
  std::vector<FreeMotion> motions = free_surface_motions(source, turns);
  if (motions.empty()) return;
  result.status = RegistrationStatus::kDegenerate;
  result.rank = 6 - static_cast<int>(motions.size());
  result.free_motions = free_surface_motions(target, turns);
  if (result.free_motions.empty()) result.free_motions = std::move(motions);
}

}  // namespace

CloudRegistration register_scaled_clouds(const geometry::PointView& source,
                                         const geometry::PointView& target,
                                         const CloudOptions& options) {
  const double start = now();
  CloudOptions rigid = options;
  rigid.registration.estimate_scale = false;
  PointCloud from = thinned(source), to = thinned(target);
  CloudRegistration registration;
  registration.result.false_alarms = std::numeric_limits<double>::infinity();
  if (std::min(from.size(), to.size()) < 4) {
    registration.result.status = RegistrationStatus::kDegenerate;
    return registration;
  }
  const Proposal proposal = propose_scale(from, to, options);
  if (std::isfinite(proposal.false_alarms)) {
    registration = register_clouds(scaled(from, proposal.scale), to, rigid);
    registration.result.scale = proposal.scale;
    // Each grid and each scale that may be tried is another chance of a false alarm.
    registration.result.false_alarms *= kScalesAGrid * static_cast<double>(kGrids.size());
    if (registration.result.T_target_source && !rigid.registration.best_effort &&
        !(registration.result.false_alarms < rigid.registration.max_false_alarms)) {
      withdraw(RegistrationStatus::kNoConsensus, registration.result);
    }
    add_normals(from, options.features, options.threads);
    add_normals(to, options.features, options.threads);
    registration = refine_scale(std::move(registration), from, to, rigid);
  } else {
    report_sliding(from, to, options.registration.turns(), registration.result);
  }
  registration.result.seconds = now() - start;
  return registration;
}

}  // namespace palpate::registration
