// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/geometry/cloud/fpfh.hpp"
#include "palpate/geometry/cloud/point_cloud.hpp"
#include "palpate/registration/registration.hpp"

namespace palpate::registration {

/// A cloud sampled to a grid, with normals and a feature for each point.
struct FeatureCloud {
  geometry::PointCloud cloud;
  geometry::Features features;     ///< one column a point, of any length: FPFH or one's own
  bool estimated_normals = false;  ///< not the cloud's own: all may be turned inside out
  /// The features are fpfh(): those of the mirror image, and of normals turned over, are known.
  bool is_fpfh = false;
};

struct FeatureOptions {
  double voxel = 0;                    ///< m, side of the grid's cells; 0 as suggested_voxel()
  int max_points = 3000;               ///< that suggested_voxel() aims at
  int normal_neighbours = 12;          ///< for normals of clouds without them
  double feature_radius_voxels = 6.0;  ///< of FPFH
  int refinements = 30;                ///< rounds of nearest neighbours after the features; 0: none

  template <class Visitor>
  void visit(Visitor&& v) {
    v("voxel", voxel, 0.0, 1e9, "grid that clouds are sampled to, m; 0: by max_points");
    v("max_points", max_points, 10, 50000, "points that the grid leaves of the larger cloud");
    v("normal_neighbours", normal_neighbours, 3, 1000, "neighbours that a normal is fitted to");
    v("feature_radius_voxels", feature_radius_voxels, 1.0, 100.0, "radius of FPFH, in cells");
    v("refinements", refinements, 0, 1000, "rounds of nearest neighbours after the features");
  }
};

/// The cell with which both clouds keep at most `max_points`, at least the mean distance between
/// the points that are left; 0 if neither has two different points.
/// @param threads  the result does not depend on them
double suggested_voxel(const geometry::PointCloud& source, const geometry::PointCloud& target,
                       int max_points, int threads = 1);

/// @param voxel  m, > 0
/// @param threads  the result does not depend on them
FeatureCloud describe(const geometry::PointView& cloud, double voxel,
                      const FeatureOptions& options = {}, int threads = 1);

struct CloudOptions {
  FeatureOptions features = {};
  /// Its noise_bound gives way to this one; its primitive is that of the refinement, its `initial`
  /// pose replaces the features, for small clouds and good guesses.
  RegistrationOptions registration = {.primitive = Primitive::kPlane};
  /// m; if not given 1.5 cells, as the points that features match sit about a cell apart.
  std::optional<double> noise_bound = std::nullopt;
  int threads = 1;  ///< the result does not depend on them
};

/// Contradiction of two clouds above which there is no pose.
inline constexpr double kMaxContradiction = 0.1;

struct CloudRegistration {
  RegistrationResult result;        ///< inliers and weights speak of `correspondences`
  Correspondences correspondences;  ///< nearest neighbours, or feature matches without refinement
  std::size_t feature_matches = 0;
  std::size_t feature_inliers = 0;    ///< of the matches, within the bound before the refinement;
                                      ///< certificate.robust speaks of these
  double voxel = 0, noise_bound = 0;  ///< m, that were used
  /// Share of the source's points whose nearest target point is within the bound, with normals that
  /// part by at most 60 deg, as the refinement's first stage (the full bound) left them.
  double overlap = 0;
  /// Share of the surface that lies off the other cloud's where it should lie on it, from 1 to 3
  /// bounds above or below; in the source and, if more than a tenth there, in the target: the
  /// smaller one. Above a tenth there is no pose, unless best_effort is set.
  double contradiction = 0;
  double rms_error = 0;        ///< m, of the refined correspondences, of the primitive
  int refinements = 0;         ///< rounds of nearest neighbours
  double feature_seconds = 0;  ///< sampling, normals, features and their matching
};

/// Pose of one cloud in another without given correspondences: mutual matches of FPFH (thesis 6.1),
/// outliers rejected as register_correspondences() does, then nearest neighbours and pose in turn,
/// the bound narrowing at the end.
///
/// Clouds of fewer than three points after sampling are kDegenerate; so are surfaces that can be
/// slid along themselves (sphere, cylinder, cone, torus, plane), with their `free_motions`. An
/// initial pose starts the refinement alone, a rotation axis or translation_only limits it and the
/// search. Large clouds are read where they are, and not copied.
///
/// With `estimate_scale` the target is T_target_source of `scale` times the source; the covariance
/// takes the scale as exact. Pairs that leave the scale free, as those of three planes do, are
/// kDegenerate with a scaling among the `free_motions`. With several `instances` each further pose
/// is found in the points of the target farther than the noise bound from the ones before.
/// @throws BadInput as check_cloud(), with_normals() and register_correspondences(), and for an
///         unknown scale with instances or an initial pose, and for either without refinements
CloudRegistration register_clouds(const geometry::PointView& source,
                                  const geometry::PointView& target,
                                  const CloudOptions& options = {});

/// The same for clouds with features of any kind, one column a point, that are nearest for like
/// places; both of the same voxel. FPFH alone distinguishes mirrored clouds from others.
/// @param voxel  m, distance between the points
/// @throws BadInput also for another number of features or normals than points, an unknown scale
///         and instances
CloudRegistration register_described(const FeatureCloud& source, const FeatureCloud& target,
                                     double voxel, const CloudOptions& options = {});

}  // namespace palpate::registration
