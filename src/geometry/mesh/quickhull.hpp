// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libqhull_r/qhull_ra.h>

#include <Eigen/Core>
#include <cstdio>

namespace palpate::geometry {

/// Convex hull of points in any dimension (Qhull; Barber, Dobkin & Huhdanpaa 1996). Owns Qhull's
/// state and the sink of its messages.
class Quickhull {
 public:
  /// @param points  dimension x n
  /// @param options  of Qhull, as "Qt"
  Quickhull(Eigen::MatrixXd points, const char* options);
  ~Quickhull();
  Quickhull(const Quickhull&) = delete;
  Quickhull& operator=(const Quickhull&) = delete;

  /// Qhull's error code; 0 if there is a hull.
  int error() const { return error_; }
  /// First of the hull's facets; the last one is followed by one without a successor.
  const facetT* facets() const { return error_ ? nullptr : state_.facet_list; }
  int index_of(const vertexT* vertex) { return qh_pointid(&state_, vertex->point); }

 private:
  Eigen::MatrixXd points_;
  qhT state_;
  std::FILE* messages_;
  int error_ = 0;
};

}  // namespace palpate::geometry
