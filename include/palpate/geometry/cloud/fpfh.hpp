// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/geometry/cloud/feature_matching.hpp"
#include "palpate/geometry/cloud/point_cloud.hpp"

namespace palpate::geometry {

inline constexpr int kFpfhBins = 33;  ///< three angles, 11 bins each

/// Fast point feature histograms (Rusu, Blodow & Beetz, ICRA 2009).
///
/// A histogram of the three angles between a point's normal and those of its neighbours, plus the
/// mean of the neighbours' histograms weighted by 1 / squared distance (the omega of the paper's
/// eq. 3 as the common implementations take it). The angles are in the order theta, alpha, phi;
/// each histogram of single pairs sums to 100, the mean too, so that a column sums to 600, or to 0
/// without neighbours.
/// @param radius  neighbourhood, m: about five times the distance between points
/// @param max_neighbours  nearest ones taken within it, and those as near as the last, the point
///        itself not counted
/// @param threads  the result does not depend on them
/// @throws BadInput for a cloud without normals, a radius that is not positive, as check_cloud()
Features fpfh(const PointCloud& cloud, double radius, int max_neighbours = 100, int threads = 1);

/// What fpfh() gives where all normals point the other way: theta and phi change sign.
Features turned_inside_out(Features features);

/// What fpfh() gives of the mirror image: alpha changes sign.
Features mirrored(Features features);

}  // namespace palpate::geometry
