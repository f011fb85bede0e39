// SPDX-License-Identifier: Apache-2.0
#include "geometry/objects/rolling.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace palpate::geometry {
namespace {

using VertexIndex = std::size_t;

VertexIndex index(int i) { return static_cast<VertexIndex>(i); }

/// Solid angle of a triangle seen from the origin (Van Oosterom & Strackee 1983), sr.
double solid_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double numerator = a.dot(b.cross(c));
  const double denominator = la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la;
  return 2 * std::atan2(numerator, denominator);
}

/// Way over an edge between two facets, and how high the centroid is at its highest there.
struct Pass {
  int from, to;
  double height;
};

class Terrain {
 public:
  Terrain(const std::vector<HullFacet>& hull, const Eigen::Vector3d& centroid)
      : hull_(hull), centroid_(centroid) {
    for (const HullFacet& facet : hull) heights_.push_back(height_over(facet));
    for (int f = 0; f < size(); ++f) sinks_.push_back(roll(f));
  }

  int size() const { return static_cast<int>(hull_.size()); }
  double height(int f) const { return heights_[index(f)]; }
  /// Where the body comes to rest after it landed on facet f.
  int sink(int f) const { return sinks_[index(f)]; }

  double landing_probability(int f) const {
    double sum = 0;
    for (const auto& [a, b, c] : hull_[index(f)].triangles) {
      sum += solid_angle(a - centroid_, b - centroid_, c - centroid_);
    }
    return sum / (4 * std::numbers::pi);
  }

  /// All passes, lowest first.
  std::vector<Pass> passes() const {
    std::vector<Pass> passes;
    for (int f = 0; f < size(); ++f) {
      for (const HullEdge& edge : hull_[index(f)].border) {
        if (f < edge.neighbour) passes.push_back({f, edge.neighbour, pass_height(f, edge)});
      }
    }
    std::ranges::stable_sort(passes, {}, &Pass::height);
    return passes;
  }

 private:
  double height_over(const HullFacet& facet) const {
    double height = 0;
    for (const auto& triangle : facet.triangles) {
      for (const Eigen::Vector3d& p : triangle) {
        height = std::max(height, facet.normal.dot(p - centroid_));
      }
    }
    return height;
  }

  /// How far inside an edge the centroid projects onto a facet with that normal; < 0: it overhangs.
  double inset(const Eigen::Vector3d& normal, const HullEdge& edge) const {
    return normal.cross(edge.to - edge.from).normalized().dot(centroid_ - edge.from);
  }

  double pass_height(int f, const HullEdge& edge) const {
    const HullEdge back{edge.to, edge.from, f};
    const double level = std::max(height(f), height(edge.neighbour));
    if (inset(hull_[index(f)].normal, edge) < 0 ||
        inset(hull_[index(edge.neighbour)].normal, back) < 0) {
      return level;
    }
    const Eigen::Vector3d along = (edge.to - edge.from).normalized();
    return std::max(level, along.cross(centroid_ - edge.from).norm());
  }

  /// Facet that the body rolls onto from f, or f itself.
  int next(int f) const {
    double least = 0;
    int next = f;
    for (const HullEdge& edge : hull_[index(f)].border) {
      const double inside = inset(hull_[index(f)].normal, edge);
      if (inside < least) {
        least = inside;
        next = edge.neighbour;
      }
    }
    return height(next) < height(f) ? next : f;  // rolling lowers the centroid; else it is rounding
  }

  int roll(int f) const {
    for (int n = next(f); n != f; n = next(f)) f = n;
    return f;
  }

  const std::vector<HullFacet>& hull_;
  Eigen::Vector3d centroid_;
  std::vector<double> heights_;
  std::vector<int> sinks_;
};

int root(std::vector<int>& parent, int i) {
  while (parent[index(i)] != i) i = parent[index(i)] = parent[index(parent[index(i)])];
  return i;
}

/// The resting facet that each resting facet gives way to: floods the terrain from below, and where
/// two valleys meet less than `barrier` above the floor of the higher, that one flows into the
/// other.
std::vector<int> give_way(const Terrain& terrain, double barrier) {
  std::vector<int> valley(index(terrain.size())), target(index(terrain.size()));
  std::iota(valley.begin(), valley.end(), 0);
  std::iota(target.begin(), target.end(), 0);
  for (const Pass& pass : terrain.passes()) {
    // A valley's root is its floor, so that its height is known.
    int low = root(valley, pass.from), high = root(valley, pass.to);
    if (low == high) continue;
    int beyond = pass.from;  // the side of the lower valley
    if (terrain.height(low) > terrain.height(high)) {
      std::swap(low, high);
      beyond = pass.to;
    }
    const bool shallow = pass.height - terrain.height(high) < barrier;
    if (shallow && terrain.sink(high) == high) target[index(high)] = terrain.sink(beyond);
    valley[index(high)] = low;
  }
  return target;
}

/// Passes the share of facets too far above their family's lowest on to the nearest that remains.
std::vector<RestingFacet> keep_lowest(const std::vector<RestingFacet>& all,
                                      const std::vector<double>& floor, double barrier) {
  std::vector<RestingFacet> kept, high;
  for (const RestingFacet& facet : all) {
    (facet.height - floor[index(facet.family)] <= barrier ? kept : high).push_back(facet);
  }
  for (const RestingFacet& facet : high) {
    const auto nearness = [&](const RestingFacet& other) {
      return other.family == facet.family ? other.normal.dot(facet.normal) : -2.0;
    };
    std::ranges::max_element(kept, {}, nearness)->probability += facet.probability;
  }
  return kept;
}

}  // namespace

std::vector<RestingFacet> resting_facets(const std::vector<HullFacet>& hull,
                                         const Eigen::Vector3d& centroid, double barrier) {
  const Terrain terrain(hull, centroid);
  std::vector<double> share(hull.size(), 0.0);
  for (int f = 0; f < terrain.size(); ++f) {
    share[index(terrain.sink(f))] += terrain.landing_probability(f);
  }
  std::vector<int> target = give_way(terrain, barrier);
  std::vector<double> floor(hull.size());
  std::vector<RestingFacet> resting;
  for (int f = 0; f < terrain.size(); ++f) {
    floor[index(f)] = terrain.height(f);
    if (terrain.sink(f) != f) continue;
    resting.push_back({hull[index(f)].normal, terrain.height(f), share[index(f)], root(target, f)});
  }
  return keep_lowest(resting, floor, barrier);
}

}  // namespace palpate::geometry
