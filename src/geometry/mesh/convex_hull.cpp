// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/convex_hull.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "geometry/mesh/quickhull.hpp"
#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

struct HullTriangle {
  std::array<int, 3> vertices;
  std::array<int, 3> neighbours = {-1, -1, -1};  // across the edge from vertex k to vertex k + 1
  Eigen::Vector3d normal;
  double area = 0;
};

/// Triangles of a hull in three dimensions, counter-clockwise seen from outside.
std::vector<HullTriangle> triangles_of(Quickhull& hull) {
  std::vector<HullTriangle> triangles;
  for (const facetT* facet = hull.facets(); facet && facet->next; facet = facet->next) {
    HullTriangle triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.vertices[k] = hull.index_of(static_cast<const vertexT*>(facet->vertices->e[k].p));
    }
    if (facet->toporient != qh_ORIENTclock) std::swap(triangle.vertices[1], triangle.vertices[2]);
    triangle.normal = Eigen::Map<const Eigen::Vector3d>(facet->normal);
    triangles.push_back(triangle);
  }
  return triangles;
}

std::vector<HullTriangle> hull_triangles(const std::vector<Eigen::Vector3d>& points,
                                         const char* options) {
  Eigen::MatrixXd columns(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = points[i];
  }
  Quickhull hull(std::move(columns), options);
  if (hull.error() != 0) {
    throw BadInput(
        fmt::format("{} points have no convex hull: they are flat or not finite (Qhull "
                    "error {})",
                    points.size(), hull.error()));
  }
  std::vector<HullTriangle> triangles = triangles_of(hull);
  for (HullTriangle& triangle : triangles) {
    const auto& [a, b, c] = triangle.vertices;
    const auto at = [&](int v) { return points[static_cast<std::size_t>(v)]; };
    triangle.area = (at(b) - at(a)).cross(at(c) - at(a)).norm() / 2;
  }
  return triangles;
}

/// Finds each triangle's neighbours; false if the triangles do not form a closed surface.
bool connect(std::vector<HullTriangle>& triangles) {
  std::map<std::pair<int, int>, int> owner;
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
    const auto& v = triangles[static_cast<std::size_t>(t)].vertices;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!owner.insert({{v[k], v[(k + 1) % 3]}, t}).second) return false;
    }
  }
  for (HullTriangle& triangle : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto twin = owner.find({triangle.vertices[(k + 1) % 3], triangle.vertices[k]});
      if (twin == owner.end()) return false;
      triangle.neighbours[k] = twin->second;
    }
  }
  return true;
}

std::vector<HullTriangle> closed_hull(const std::vector<Eigen::Vector3d>& points) {
  // Triangulating a facet of many vertices (Qt) can fold it; joggled input (QJ) has no such facets.
  for (const char* options : {"Qt", "QJ"}) {
    std::vector<HullTriangle> triangles = hull_triangles(points, options);
    if (connect(triangles)) return triangles;
  }
  throw BadInput(fmt::format("the convex hull of {} points is not closed", points.size()));
}

/// Facet of each triangle: grown from the largest triangles over neighbours in the same plane.
std::vector<int> group_by_plane(const std::vector<HullTriangle>& triangles, double flat) {
  std::vector<std::size_t> by_area(triangles.size());
  std::iota(by_area.begin(), by_area.end(), 0);
  std::ranges::stable_sort(by_area, std::greater{},
                           [&](std::size_t t) { return triangles[t].area; });
  std::vector<int> facet(triangles.size(), -1);
  int count = 0;
  for (std::size_t seed : by_area) {
    if (facet[seed] >= 0) continue;
    std::vector<std::size_t> open = {seed};
    facet[seed] = count;
    while (!open.empty()) {
      const HullTriangle& triangle = triangles[open.back()];
      open.pop_back();
      for (int n : triangle.neighbours) {
        const auto next = static_cast<std::size_t>(n);
        if (facet[next] >= 0 ||
            triangles[next].normal.dot(triangles[seed].normal) < std::cos(flat)) {
          continue;
        }
        facet[next] = count;
        open.push_back(next);
      }
    }
    ++count;
  }
  return facet;
}

}  // namespace

std::vector<Eigen::Vector3d> hull_corners(const std::vector<Eigen::Vector3d>& points) {
  std::set<int> corners;
  for (const HullTriangle& triangle : closed_hull(points)) {
    corners.insert(triangle.vertices.begin(), triangle.vertices.end());
  }
  std::vector<Eigen::Vector3d> result;
  for (const int corner : corners) result.push_back(points[static_cast<std::size_t>(corner)]);
  return result;
}

std::vector<HullFacet> convex_hull(const std::vector<Eigen::Vector3d>& points, double flat) {
  if (points.size() < 4) {
    throw BadInput(fmt::format("a convex hull needs at least 4 points, not {}", points.size()));
  }
  const std::vector<HullTriangle> triangles = closed_hull(points);
  const std::vector<int> group = group_by_plane(triangles, flat);
  std::vector<HullFacet> facets(static_cast<std::size_t>(1 + *std::ranges::max_element(group)));
  for (HullFacet& facet : facets) facet.normal.setZero();
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    HullFacet& facet = facets[static_cast<std::size_t>(group[t])];
    std::array<Eigen::Vector3d, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = points[static_cast<std::size_t>(triangles[t].vertices[k])];
    }
    facet.normal += triangles[t].area * triangles[t].normal;
    facet.triangles.push_back(corners);
    for (std::size_t k = 0; k < 3; ++k) {
      const int neighbour = group[static_cast<std::size_t>(triangles[t].neighbours[k])];
      if (neighbour != group[t])
        facet.border.push_back({corners[k], corners[(k + 1) % 3], neighbour});
    }
  }
  for (HullFacet& facet : facets) facet.normal.normalize();
  return facets;
}

}  // namespace palpate::geometry
