// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/query/rounded_hull.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/mesh/convex_hull.hpp"
#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

using HullPoints = std::vector<Eigen::Vector3d>;

constexpr double kOneCorner = 1e-5;  // m, between points that count as one
constexpr double kOneFacet = 2e-3;   // rad, between parts of one facet
constexpr double kNoPlane = 1e-6;    // rad
constexpr double kSmoothest = 0.3;   // rad, between parts of one facet of what is simplified
constexpr std::size_t kMaxFacets = 100;
constexpr int kCenterSteps = 400;
constexpr double kOnBorder = 1e-9;  // m, that a facet's border may be passed

double offset_of(const HullFacet& facet) {
  double offset = -std::numeric_limits<double>::infinity();
  for (const HullEdge& edge : facet.border) offset = std::max(offset, facet.normal.dot(edge.from));
  return offset;
}

/// Planes of the convex hull's facets, of which like ones are joined if there are many, and of the
/// cut.
std::vector<HalfSpace> planes_of(const HullPoints& points, const std::optional<HalfSpace>& cut) {
  std::vector<HullFacet> facets;
  double flat = kOneFacet;
  do {
    facets = convex_hull(points, flat);
    flat *= 2;
  } while (facets.size() > kMaxFacets && flat < kSmoothest);
  std::vector<HalfSpace> planes;
  for (const HullFacet& facet : facets) planes.push_back({facet.normal, offset_of(facet)});
  if (cut) planes.push_back(*cut);
  return planes;
}

double room_below(const HalfSpace& plane, const Eigen::Vector3d& p) {
  return plane.offset - plane.normal.dot(p);
}

const HalfSpace& nearest_plane(const std::vector<HalfSpace>& planes, const Eigen::Vector3d& p) {
  return *std::ranges::min_element(planes, {},
                                   [&](const HalfSpace& plane) { return room_below(plane, p); });
}

/// About the middle of the largest ball inside: away from the nearest plane, in shorter and shorter
/// steps.
Eigen::Vector3d center_of(const std::vector<HalfSpace>& planes, const HullPoints& points) {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (const auto& point : points) p += point / static_cast<double>(points.size());
  double step = 0;
  for (const auto& point : points) step = std::max(step, (point - p).norm() / 2);
  Eigen::Vector3d best = p;
  for (int i = 0; i < kCenterSteps; ++i, step *= 0.98) {
    const HalfSpace& plane = nearest_plane(planes, p);
    if (room_below(plane, p) > room_below(nearest_plane(planes, best), best)) best = p;
    p -= step * plane.normal;
  }
  return best;
}

/// Corners of the planes' intersection: facets of the hull of the dual points about a point inside.
HullPoints corners_within(const std::vector<HalfSpace>& planes, const Eigen::Vector3d& center,
                          double shrunk) {
  HullPoints dual;
  dual.reserve(planes.size());
  for (const HalfSpace& plane : planes) {
    dual.emplace_back(plane.normal / (room_below(plane, center) - shrunk));
  }
  HullPoints corners;
  for (const HullFacet& facet : convex_hull(dual, kNoPlane)) {
    const double offset = offset_of(facet);
    if (!(offset > 0)) continue;
    const Eigen::Vector3d corner = center + facet.normal / offset;
    const bool known = std::ranges::any_of(
        corners, [&](const auto& other) { return (corner - other).norm() < kOneCorner; });
    if (!known) corners.push_back(corner);
  }
  return corners;
}

/// Corners, and a grid over the facets' triangles between their borders and middles.
HullPoints surface_grid(const RoundedHull& hull) {
  constexpr int kSteps = 6;
  HullPoints points = hull.core();
  for (const RoundedHull::Facet& facet : hull.facets()) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const auto& side : facet.border) {
      middle += side.from / static_cast<double>(facet.border.size());
    }
    for (std::size_t i = 0; i < facet.border.size(); ++i) {
      const Eigen::Vector3d& from = facet.border[i].from;
      const Eigen::Vector3d to = from + facet.border[i].along;
      for (int u = 0; u < kSteps; ++u) {
        for (int v = 0; u + v <= kSteps; ++v) {
          const double a = static_cast<double>(u) / kSteps, b = static_cast<double>(v) / kSteps;
          points.emplace_back((1 - a - b) * middle + a * from + b * to);
        }
      }
    }
  }
  return points;
}

Eigen::Vector3d nearest_on(const RoundedHull::Edge& edge, const Eigen::Vector3d& p) {
  const Eigen::Vector3d way = edge.to - edge.from;
  const double s = std::clamp(way.dot(p - edge.from) / way.squaredNorm(), 0.0, 1.0);
  return edge.from + s * way;
}

}  // namespace

bool RoundedHull::Facet::covers(const Eigen::Vector3d& p) const {
  return std::ranges::none_of(
      border, [&](const Side& side) { return side.inward.dot(p - side.from) < -kOnBorder; });
}

RoundedHull::RoundedHull(const HullPoints& points, double radius) : radius_(radius) {
  if (!(std::isfinite(radius) && radius > 0)) {
    throw BadInput(fmt::format("the radius of a rounded hull must be positive, not {} m", radius));
  }
  const std::vector<HullFacet> hull = convex_hull(points, kOneFacet);
  const auto corner_at = [&](const Eigen::Vector3d& p) -> Corner& {
    for (Corner& corner : corners_) {
      if (corner.p == p) return corner;
    }
    return corners_.emplace_back(p, HullPoints{});
  };
  for (std::size_t i = 0; i < hull.size(); ++i) {
    Facet facet{hull[i].normal, offset_of(hull[i]), {}, {}};
    for (const HullEdge& edge : hull[i].border) {
      const Eigen::Vector3d way = (edge.to - edge.from).normalized();
      const Eigen::Vector3d inward = facet.normal.cross(way);
      facet.border.push_back({edge.from, edge.to - edge.from, inward});
      facet.box.extend(edge.from);
      corner_at(edge.from).ways.push_back(way);  // the other way round it is its neighbour's edge
      const auto other = static_cast<std::size_t>(edge.neighbour);
      if (i < other) {
        edges_.push_back({edge.from, edge.to, {inward, hull[other].normal.cross(-way)}});
      }
    }
    facets_.push_back(std::move(facet));
  }
}

RoundedHull RoundedHull::within(const HullPoints& points, double radius,
                                const std::optional<HalfSpace>& cut) {
  const std::vector<HalfSpace> planes = planes_of(points, cut);
  const Eigen::Vector3d center = center_of(planes, points);
  const double room = room_below(nearest_plane(planes, center), center);
  if (!(room > 0)) throw BadInput("nothing is left of the hull that is cut");
  const double rounding = std::min(radius, room / 2);
  return {corners_within(planes, center, rounding), rounding};
}

std::vector<Eigen::Vector3d> RoundedHull::core() const {
  HullPoints points;
  points.reserve(corners_.size());
  for (const Corner& corner : corners_) points.push_back(corner.p);
  return points;
}

std::vector<Eigen::Vector3d> RoundedHull::surface_points() const {
  HullPoints points;
  for (const Facet& facet : facets_) {
    for (const Side& side : facet.border) points.push_back(side.from + radius_ * facet.normal);
  }
  for (const Corner& corner : corners_) {
    Eigen::Vector3d out = Eigen::Vector3d::Zero();
    for (const Facet& facet : facets_) {
      const auto is_there = [&](const Side& side) { return side.from == corner.p; };
      if (std::ranges::any_of(facet.border, is_there)) out += facet.normal;
    }
    points.push_back(corner.p + radius_ * out.normalized());
  }
  return points;
}

std::vector<Eigen::Vector3d> RoundedHull::spread_over_core(int count,
                                                           const Eigen::Vector3d& p) const {
  const HullPoints all = surface_grid(*this);
  HullPoints chosen;
  std::vector<double> distance(all.size());
  for (std::size_t k = 0; k < all.size(); ++k) distance[k] = 1 / (1 + (all[k] - p).norm());
  // The farthest of the first `among` from what is chosen, as long as that is another point.
  const auto choose = [&](std::size_t among, std::size_t up_to) {
    while (chosen.size() < up_to) {
      const auto end = distance.begin() + static_cast<std::ptrdiff_t>(among);
      const auto next = std::max_element(distance.begin(), end);
      if (*next <= kOneCorner) return;
      const Eigen::Vector3d& point = all[static_cast<std::size_t>(next - distance.begin())];
      for (std::size_t k = 0; k < all.size(); ++k) {
        const double to_point = (all[k] - point).norm();
        distance[k] = chosen.empty() ? to_point : std::min(distance[k], to_point);
      }
      chosen.push_back(point);
    }
  };
  const auto wanted = static_cast<std::size_t>(count);
  choose(all.size(), std::min<std::size_t>(wanted, 1));
  choose(corners_.size(), wanted / 2);
  choose(all.size(), wanted);
  return chosen;
}

double RoundedHull::above_facets(const Eigen::Vector3d& p) const {
  double most = -std::numeric_limits<double>::infinity();
  for (const Facet& facet : facets_) most = std::max(most, facet.normal.dot(p) - facet.offset);
  return most;
}

Eigen::Vector3d RoundedHull::nearest_in_core(const Eigen::Vector3d& p) const {
  if (above_facets(p) <= 0) return p;
  Eigen::Vector3d best = corners_.front().p;
  const auto consider = [&](const Eigen::Vector3d& q) {
    if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
  };
  for (const Edge& edge : edges_) consider(nearest_on(edge, p));
  for (const Facet& facet : facets_) {
    const double height = facet.normal.dot(p) - facet.offset;
    if (height > 0 && facet.covers(p)) consider(p - height * facet.normal);
  }
  return best;
}

}  // namespace palpate::geometry
