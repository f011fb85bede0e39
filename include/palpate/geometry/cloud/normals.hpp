// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/geometry/cloud/kd_tree.hpp"
#include "palpate/geometry/cloud/point_cloud.hpp"

namespace palpate::geometry {

/// Unit normal of the plane through the `neighbours` points nearest to a place; of either sign.
/// Nothing where they are collinear.
std::optional<Eigen::Vector3d> plane_normal(const KdTree& tree, const Eigen::Vector3d& at,
                                            int neighbours);

/// What becomes of points whose neighbours are collinear, as on a wire or beside a far point.
enum class CollinearPoints { kRefuse, kDrop };

/// The cloud with the unit normal of the plane through each point's `neighbours` nearest points
/// (itself among them), by principal components (Hoppe et al. 1992, 3.2); of either sign.
/// @param threads  the result does not depend on them
/// @throws BadInput as check_cloud(), for fewer than three neighbours, or for a point whose
///         neighbours are collinear, unless such points are dropped
PointCloud with_plane_normals(PointCloud cloud, int neighbours, int threads,
                              CollinearPoints collinear);

/// The cloud with_plane_normals(), flipped so that they agree along a minimum spanning tree of
/// the neighbours' graph with weights 1 - |n_i . n_j|, each part of it pointing outward at its
/// highest point (Hoppe et al. 1992, 3.3). For closed surfaces normals then point out.
/// @param threads  the result does not depend on them
/// @throws BadInput as with_plane_normals()
PointCloud with_normals(PointCloud cloud, int neighbours = 12, int threads = 1,
                        CollinearPoints collinear = CollinearPoints::kRefuse);

}  // namespace palpate::geometry
