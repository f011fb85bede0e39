// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

namespace palpate::geometry {

/// All points p with normal . p <= offset.
struct HalfSpace {
  Eigen::Vector3d normal;  ///< unit
  double offset = 0;       ///< m
};

/// A convex body with rounded edges: all points within a radius of the convex hull of some points,
/// its core. Immutable, so that threads may share it.
class RoundedHull {
 public:
  /// Straight edge of the core.
  struct Edge {
    Eigen::Vector3d from, to;
    std::array<Eigen::Vector3d, 2> into;  ///< across the edge, along the facets it joins; unit
  };
  /// A line's side on which a facet lies.
  struct Side {
    Eigen::Vector3d from, along, inward;  ///< along: to its end, m; inward: unit
  };
  /// Flat part of the core's surface.
  struct Facet {
    Eigen::Vector3d normal;  ///< outward, unit
    double offset = 0;       ///< normal . p of its points, m
    std::vector<Side> border;
    Eigen::AlignedBox3d box;  ///< around it

    /// Whether p lies above or below it, not beside it.
    bool covers(const Eigen::Vector3d& p) const;
  };
  struct Corner {
    Eigen::Vector3d p;
    std::vector<Eigen::Vector3d> ways;  ///< along the edges that start there, unit
  };

  /// @param points  of which the core is the convex hull; those inside are left out
  /// @throws BadInput if they span no volume, or the radius is not positive
  RoundedHull(const std::vector<Eigen::Vector3d>& points, double radius);

  /// The body within the convex hull of points whose faces are the hull's: its edges are rounded
  /// with `radius`, or with half of the radius of the largest ball inside if that is less.
  /// @param cut  ends the body, if given
  /// @throws BadInput if nothing is left
  static RoundedHull within(const std::vector<Eigen::Vector3d>& points, double radius,
                            const std::optional<HalfSpace>& cut = {});

  double radius() const { return radius_; }
  const std::vector<Corner>& corners() const { return corners_; }
  const std::vector<Edge>& edges() const { return edges_; }
  const std::vector<Facet>& facets() const { return facets_; }

  /// The core's corners alone.
  std::vector<Eigen::Vector3d> core() const;

  /// Points of the rounded surface: where its facets end, and out from the core's corners. Their
  /// convex hull lies within the body.
  std::vector<Eigen::Vector3d> surface_points() const;

  /// Points spread over the core's surface, at most `count`: the nearest to p, then corners until
  /// they are half of all, then of the whole surface, each as far as can be from those before.
  std::vector<Eigen::Vector3d> spread_over_core(int count, const Eigen::Vector3d& p) const;

  /// Largest distance of p above the planes of the core's facets, m: at most its distance from the
  /// core, and negative within it.
  double above_facets(const Eigen::Vector3d& p) const;

  /// The core's point nearest to p; p itself if it lies in the core.
  Eigen::Vector3d nearest_in_core(const Eigen::Vector3d& p) const;

 private:
  double radius_ = 0;
  std::vector<Corner> corners_;
  std::vector<Edge> edges_;
  std::vector<Facet> facets_;
};

}  // namespace palpate::geometry
