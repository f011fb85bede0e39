// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/query/collider_surface.hpp"

namespace palpate::geometry {
namespace {

constexpr double kSunkIn = 0.002;  // m beyond the reach, that the core may be sunk in
/// Sine of the angle by which what a corner or edge meets may lie beside where it points: then it
/// is not the lowest place of a tilted facet, but bears part of the load.
const double kBeside = std::sin(15 * std::numbers::pi / 180);

/// A hull at a place near a surface, and the pairs of its core's features with the triangles'.
/// Triangles and pairs are sought in the hull's frame.
class HullMeeting {
 public:
  using Surface = CapsuleCollider::Surface;

  HullMeeting(const Surface& surface, const RoundedHull& hull, const Eigen::Isometry3d& T_mesh_hull,
              double reach)
      : surface_(surface),
        hull_(hull),
        T_mesh_hull_(T_mesh_hull),
        T_hull_mesh_(T_mesh_hull.inverse()),
        reach_(reach),
        at_corner_(hull.corners().size()) {
    surface.bvh.visit_box(box(), [&](int triangle) { add_triangle(triangle); });
    choose_features();
    for (const Triangle& triangle : triangles_) {
      meet_corners(triangle);
      meet_edges(triangle);
      meet_facets(triangle);
    }
  }

  std::vector<Candidate> outside_candidates() const;

 private:
  struct Triangle {
    int number;
    Corners corners;
    Eigen::Vector3d center, normal;
    double radius;
  };

  Eigen::AlignedBox3d box() const;
  void add_triangle(int number);
  void choose_features();
  void meet_corners(const Triangle& triangle);
  void meet_edges(const Triangle& triangle);
  void meet_facets(const Triangle& triangle);
  void meet_facet(const RoundedHull::Facet& facet, const Triangle& triangle, int corner);
  Candidate in_mesh(Candidate c, int triangle) const {
    c.p = T_mesh_hull_ * c.p;
    c.q = T_mesh_hull_ * c.q;
    c.triangle = triangle;
    return c;
  }
  bool points_at(const RoundedHull::Corner& corner, const Candidate& c) const;

  const Surface& surface_;
  const RoundedHull& hull_;
  Eigen::Isometry3d T_mesh_hull_, T_hull_mesh_;
  double reach_;
  std::vector<Triangle> triangles_;   // that may be within reach
  Eigen::AlignedBox3d where_;         // they are
  std::vector<std::size_t> corners_;  // of the core, that may be within reach of them
  std::vector<const RoundedHull::Edge*> edges_;
  std::vector<const RoundedHull::Facet*> facets_;
  std::vector<std::vector<Candidate>> at_corner_;
  std::vector<Candidate> elsewhere_;
};

Eigen::AlignedBox3d HullMeeting::box() const {
  Eigen::AlignedBox3d box;
  for (const auto& corner : hull_.corners()) box.extend(T_mesh_hull_ * corner.p);
  const Eigen::Vector3d around = Eigen::Vector3d::Constant(reach_ + kSunkIn);
  return {box.min() - around, box.max() + around};
}

void HullMeeting::add_triangle(int number) {
  const Bound& bound = surface_.bounds[static_cast<std::size_t>(number)];
  if (bound.radius < 0) return;
  Triangle triangle{number, surface_.corners_of(number), T_hull_mesh_ * bound.center,
                    T_hull_mesh_.linear() * surface_.normals.at(number, Feature::kFace),
                    bound.radius};
  if (hull_.above_facets(triangle.center) > reach_ + kSunkIn + bound.radius) return;
  for (Eigen::Vector3d& corner : triangle.corners) {
    corner = T_hull_mesh_ * corner;
    where_.extend(corner);
  }
  triangles_.push_back(triangle);
}

/// Of a core of many corners most are elsewhere.
void HullMeeting::choose_features() {
  if (triangles_.empty()) return;
  const Eigen::Vector3d around = Eigen::Vector3d::Constant(reach_ + kSunkIn);
  const Eigen::AlignedBox3d near(where_.min() - around, where_.max() + around);
  for (std::size_t i = 0; i < hull_.corners().size(); ++i) {
    if (near.contains(hull_.corners()[i].p)) corners_.push_back(i);
  }
  for (const RoundedHull::Edge& edge : hull_.edges()) {
    const Eigen::AlignedBox3d box(edge.from.cwiseMin(edge.to), edge.from.cwiseMax(edge.to));
    if (near.intersects(box)) edges_.push_back(&edge);
  }
  for (const RoundedHull::Facet& facet : hull_.facets()) {
    if (near.intersects(facet.box)) facets_.push_back(&facet);
  }
}

void HullMeeting::meet_corners(const Triangle& triangle) {
  const double deep = reach_ + kSunkIn, far = deep + triangle.radius;
  for (const std::size_t i : corners_) {
    const Eigen::Vector3d& p = hull_.corners()[i].p;
    const Eigen::Vector3d from = p - triangle.center;
    if (from.squaredNorm() > far * far || std::abs(triangle.normal.dot(from)) > deep) continue;
    const TrianglePoint nearest = closest_point_on_triangle(p, triangle.corners);
    const Candidate c{.p = p, .q = nearest.point, .feature = nearest.feature};
    if (c.length() < deep) at_corner_[i].push_back(in_mesh(c, triangle.number));
  }
}

void HullMeeting::meet_edges(const Triangle& triangle) {
  const double far = reach_ + triangle.radius;
  for (const RoundedHull::Edge* const edge : edges_) {
    const Capsule axis{edge->from, edge->to, hull_.radius()};
    if (squared_distance_to_axis(axis, triangle.center) > far * far ||
        is_beyond(axis, reach_, triangle.center, triangle.normal)) {
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      const auto c = axis_to_edge(axis, triangle.corners, k);
      if (!c || c->length() >= reach_) continue;
      const Eigen::Vector3d way = c->q - c->p;
      if (std::max(edge->into[0].dot(way), edge->into[1].dot(way)) > kBeside * way.norm()) continue;
      elsewhere_.push_back(in_mesh(*c, triangle.number));
    }
  }
}

void HullMeeting::meet_facets(const Triangle& triangle) {
  for (const RoundedHull::Facet* const facet : facets_) {
    const double height = facet->normal.dot(triangle.center) - facet->offset;
    if (std::abs(height) > reach_ + kSunkIn + triangle.radius) continue;
    for (int corner = 0; corner < 3; ++corner) meet_facet(*facet, triangle, corner);
  }
}

/// A corner of the mesh above or below a facet of the core.
void HullMeeting::meet_facet(const RoundedHull::Facet& facet, const Triangle& triangle,
                             int corner) {
  const Eigen::Vector3d& q = triangle.corners[static_cast<std::size_t>(corner)];
  const double height = facet.normal.dot(q) - facet.offset;
  if (height >= reach_ || height < -kSunkIn || !facet.covers(q)) return;
  if (height <= 0 && hull_.above_facets(q) > height) return;  // another facet is nearer
  Candidate c = in_mesh({.p = q - height * facet.normal,
                         .q = q,
                         .feature = static_cast<Feature>(corner),
                         .is_interior = true},
                        triangle.number);
  if (height <= kOnSurface) {
    c.normal = -(T_mesh_hull_.linear() * facet.normal);
    c.gap = height - hull_.radius();
    c.is_proven = true;
    if (c.normal.dot(surface_.pseudonormal(c)) <= 0) return;
  }
  elsewhere_.push_back(c);
}

/// Whether a corner is about the place of the core that is nearest to what it meets.
bool HullMeeting::points_at(const RoundedHull::Corner& corner, const Candidate& c) const {
  const Eigen::Vector3d way = T_hull_mesh_.linear() * (c.q - c.p);
  return std::ranges::all_of(corner.ways, [&](const Eigen::Vector3d& along) {
    return along.dot(way) <= kBeside * way.norm();
  });
}

std::vector<Candidate> HullMeeting::outside_candidates() const {
  std::vector<Candidate> kept;
  const Capsule ball{{}, {}, hull_.radius()};
  for (const std::size_t i : corners_) {
    if (at_corner_[i].empty()) continue;
    std::vector<Candidate> own;
    surface_.resolve_end(ball, at_corner_[i].front().p, at_corner_[i], own);
    std::ranges::copy_if(own, std::back_inserter(kept), [&](const Candidate& c) {
      return c.is_proven || points_at(hull_.corners()[i], c);
    });
  }
  kept.insert(kept.end(), elsewhere_.begin(), elsewhere_.end());
  surface_.erase_seen_from_behind(hull_.radius(), kept);
  return kept;
}

}  // namespace

std::vector<CapsuleContact> CapsuleCollider::contacts(const RoundedHull& hull,
                                                      const Eigen::Isometry3d& T_mesh_hull,
                                                      double margin, int limit) const {
  const HullMeeting meeting(*surface_, hull, T_mesh_hull, hull.radius() + margin);
  return surface_->chosen(meeting.outside_candidates(), margin, limit);
}

}  // namespace palpate::geometry
