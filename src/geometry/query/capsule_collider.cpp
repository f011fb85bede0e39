// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/query/capsule_collider.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "geometry/query/collider_surface.hpp"

namespace palpate::geometry {
namespace {

constexpr double kTie = 1e-8;       // m, by which a neighbour must be closer to count
constexpr double kApart = 0.006;    // m, between contacts of like normals
constexpr double kInterior = 1e-6;  // share of the axis left to its ends
constexpr double kFlat = 1e-9;      // 1 - cosine between normals of one plane
const double kLikeNormal = std::cos(15 * std::numbers::pi / 180);

bool before(const Candidate& a, const Candidate& b) {
  return std::tie(a.gap, a.triangle) < std::tie(b.gap, b.triangle);
}

Eigen::AlignedBox3d reach_of(const Capsule& capsule, double reach) {
  const Eigen::Vector3d around = Eigen::Vector3d::Constant(reach);
  return {capsule.a.cwiseMin(capsule.b) - around, capsule.a.cwiseMax(capsule.b) + around};
}

bool alike(const CapsuleContact& a, const CapsuleContact& b) {
  return a.normal.dot(b.normal) > kLikeNormal;
}

bool close(const CapsuleContact& a, const CapsuleContact& b) {
  return (a.point - b.point).norm() < kApart;
}

}  // namespace

Bound bound_of(const Corners& t) {
  const Eigen::Vector3d center = (t[0] + t[1] + t[2]) / 3;
  if (is_degenerate(t)) return {center, -1};
  return {center,
          std::max({(t[0] - center).norm(), (t[1] - center).norm(), (t[2] - center).norm()})};
}

double squared_distance_to_axis(const Capsule& capsule, const Eigen::Vector3d& p) {
  const Eigen::Vector3d axis = capsule.b - capsule.a;
  const double squared = axis.squaredNorm();
  const double s = squared > 0 ? std::clamp(axis.dot(p - capsule.a) / squared, 0.0, 1.0) : 0;
  return (capsule.a + s * axis - p).squaredNorm();
}

bool is_beyond(const Capsule& capsule, double reach, const Eigen::Vector3d& on_plane,
               const Eigen::Vector3d& normal) {
  const double a = normal.dot(capsule.a - on_plane), b = normal.dot(capsule.b - on_plane);
  return std::min(a, b) > reach || std::max(a, b) < -reach;
}

std::optional<Candidate> axis_to_edge(const Capsule& capsule, const Corners& t, int k) {
  const auto next = (k + 1) % 3;
  const Eigen::Vector3d& corner = t[static_cast<std::size_t>(k)];
  const Eigen::Vector3d axis = capsule.b - capsule.a;
  const Eigen::Vector3d edge = t[static_cast<std::size_t>(next)] - corner;
  const Eigen::Vector3d w = capsule.a - corner;
  const double aa = axis.squaredNorm(), ee = edge.squaredNorm(), ae = axis.dot(edge);
  const double determinant = aa * ee - ae * ae;
  if (determinant < 1e-12 * aa * ee) return std::nullopt;
  double s = (ae * edge.dot(w) - ee * axis.dot(w)) / determinant;
  const double u = (ae * s + edge.dot(w)) / ee;
  Candidate result;
  result.feature = static_cast<Feature>(3 + k);
  result.is_interior = true;
  if (u <= 0) {
    s = -axis.dot(w) / aa;
    result.feature = static_cast<Feature>(k);
  } else if (u >= 1) {
    s = (ae - axis.dot(w)) / aa;
    result.feature = static_cast<Feature>(next);
  }
  if (s <= kInterior || s >= 1 - kInterior) return std::nullopt;
  result.p = capsule.a + s * axis;
  result.q = corner + std::clamp(u, 0.0, 1.0) * edge;
  return result;
}

/// Pairs of every nearby triangle with the axis, whichever side of the triangle the axis is on.
std::vector<Candidate> CapsuleCollider::Surface::candidates(const Capsule& capsule,
                                                            double reach) const {
  std::vector<Candidate> result;
  const bool is_ball = (capsule.b - capsule.a).squaredNorm() < kOnSurface * kOnSurface;
  const auto add = [&](Candidate c, int triangle) {
    if (c.length() >= reach) return;
    c.triangle = triangle;
    result.push_back(c);
  };
  bvh.visit_box(reach_of(capsule, reach), [&](int triangle) {
    const Bound& bound = bounds[static_cast<std::size_t>(triangle)];
    const double far = reach + bound.radius;
    if (bound.radius < 0 || squared_distance_to_axis(capsule, bound.center) > far * far) return;
    if (is_beyond(capsule, reach, bound.center, normals.at(triangle, Feature::kFace))) return;
    const Corners t = corners_of(triangle);
    for (const Eigen::Vector3d& end : {capsule.a, capsule.b}) {
      const TrianglePoint nearest = closest_point_on_triangle(end, t);
      add({.p = end, .q = nearest.point, .feature = nearest.feature}, triangle);
      if (is_ball) return;
    }
    for (int k = 0; k < 3; ++k) {
      if (const auto c = axis_to_edge(capsule, t, k)) add(*c, triangle);
    }
  });
  return result;
}

/// Decides on which side of the surface an end of the axis is, and keeps its pairs accordingly.
void CapsuleCollider::Surface::resolve_end(const Capsule& capsule, const Eigen::Vector3d& end,
                                           const std::vector<Candidate>& all,
                                           std::vector<Candidate>& kept) const {
  const Candidate* nearest = nullptr;
  for (const Candidate& c : all) {
    if (c.p == end && (!nearest || c.length() < nearest->length())) nearest = &c;
  }
  if (!nearest) return;
  const double length = nearest->length();
  double side = 1;
  if (length > kOnSurface && (nearest->p - nearest->q).dot(pseudonormal(*nearest)) < 0) {
    // Pseudonormals of slivers are sometimes wrong: only rays decide for sure.
    side = query.inside(end) ? -1 : 1;
    Candidate out = *nearest;
    out.normal = side * (out.p - out.q) / length;
    out.gap = side * length - capsule.radius;
    out.is_proven = true;
    kept.push_back(out);
  }
  if (side < 0) return;
  std::copy_if(all.begin(), all.end(), std::back_inserter(kept),
               [&](const Candidate& c) { return c.p == end; });
}

std::vector<Candidate> CapsuleCollider::Surface::outside_candidates(const Capsule& capsule,
                                                                    double reach) const {
  const std::vector<Candidate> all = candidates(capsule, reach);
  std::vector<Candidate> kept;
  resolve_end(capsule, capsule.a, all, kept);
  if (capsule.a != capsule.b) resolve_end(capsule, capsule.b, all, kept);
  std::copy_if(all.begin(), all.end(), std::back_inserter(kept),
               [](const Candidate& c) { return c.is_interior; });
  erase_seen_from_behind(capsule.radius, kept);
  return kept;
}

/// Completes candidates and leaves out those that see the surface from behind.
void CapsuleCollider::Surface::erase_seen_from_behind(double radius,
                                                      std::vector<Candidate>& kept) const {
  std::erase_if(kept, [&](Candidate& c) {
    if (c.is_proven) return false;
    const double length = c.length();
    const Eigen::Vector3d outward = pseudonormal(c);
    c.gap = length - radius;
    c.normal = length > kOnSurface ? Eigen::Vector3d((c.p - c.q) / length) : outward;
    return c.normal.dot(outward) <= 0;
  });
}

/// Whether the surface around q is a plane along the axis: then the axis is as close all along,
/// until it or the plane ends, and those places are more informative.
bool CapsuleCollider::Surface::is_flat(const Candidate& c) const {
  const auto faces_p = [&](int triangle) {
    return normals.at(triangle, Feature::kFace).dot(c.normal) > 1 - kFlat;
  };
  bool result = faces_p(c.triangle);
  adjacency.visit_sharing(c.triangle, c.feature,
                          [&](int neighbour) { result = result && faces_p(neighbour); });
  return result;
}

bool CapsuleCollider::Surface::is_local_minimum(const Candidate& c) const {
  if (c.is_interior && is_flat(c)) return false;
  bool result = true;
  const auto compare = [&](int triangle) {
    if (bounds[static_cast<std::size_t>(triangle)].radius < 0) return;
    const Corners t = corners_of(triangle);
    const double length = (closest_point_on_triangle(c.p, t).point - c.p).norm();
    result = result && length >= c.length() - kTie;
  };
  compare(c.triangle);
  adjacency.visit_sharing(c.triangle, c.feature, compare);
  return result;
}

void CapsuleCollider::Surface::select(const std::vector<Candidate>& sorted, bool new_normals_only,
                                      std::size_t limit,
                                      std::vector<CapsuleContact>& chosen) const {
  for (const Candidate& c : sorted) {
    if (chosen.size() >= limit) return;
    const CapsuleContact contact{c.q, c.normal, c.gap};
    const bool is_known = std::any_of(chosen.begin(), chosen.end(), [&](const auto& other) {
      return alike(contact, other) && (new_normals_only || close(contact, other));
    });
    if (!is_known && (c.is_proven || is_local_minimum(c))) chosen.push_back(contact);
  }
}

/// The deepest that differ, at most `limit`.
std::vector<CapsuleContact> CapsuleCollider::Surface::chosen(std::vector<Candidate> found,
                                                             double margin, int limit) const {
  std::erase_if(found, [&](const Candidate& c) { return !(c.gap < margin); });
  std::sort(found.begin(), found.end(), before);
  std::vector<CapsuleContact> chosen;
  const auto room = static_cast<std::size_t>(std::max(limit, 0));
  select(found, true, room, chosen);
  select(found, false, room, chosen);
  return chosen;
}

CapsuleCollider::CapsuleCollider(const MeshQuery& mesh)
    : surface_(std::make_unique<const Surface>(mesh)) {}
CapsuleCollider::~CapsuleCollider() = default;
CapsuleCollider::CapsuleCollider(CapsuleCollider&&) noexcept = default;

std::vector<CapsuleContact> CapsuleCollider::contacts(const Capsule& capsule, double margin,
                                                      int limit) const {
  return surface_->chosen(surface_->outside_candidates(capsule, capsule.radius + margin), margin,
                          limit);
}

}  // namespace palpate::geometry
