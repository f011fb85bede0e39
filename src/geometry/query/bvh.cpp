// SPDX-License-Identifier: Apache-2.0
#include "geometry/query/bvh.hpp"

#include <algorithm>

namespace palpate::geometry {
namespace {

constexpr int kTrianglesPerLeaf = 4;
constexpr int kStackSize = 64;  // median splits halve the count, so an int's worth of levels is 32

Eigen::Vector3d centre(const Corners& t) { return (t[0] + t[1] + t[2]) / 3; }

double squared_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& low,
                        const Eigen::Vector3d& high) {
  return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
}

/// Slab test (Kay & Kajiya 1986). Planes that the ray runs along give infinities or, where it lies
/// in the plane itself, NaN, which the order of min and max lets pass as "within".
bool ray_meets_box(const Eigen::Vector3d& origin, const Eigen::Vector3d& inverse,
                   const Eigen::Vector3d& low, const Eigen::Vector3d& high, double reach) {
  double enter = 0, leave = reach;
  for (int axis = 0; axis < 3; ++axis) {
    const double s = (low[axis] - origin[axis]) * inverse[axis];
    const double t = (high[axis] - origin[axis]) * inverse[axis];
    const double first = inverse[axis] < 0 ? t : s, last = inverse[axis] < 0 ? s : t;
    enter = first > enter ? first : enter;
    leave = last < leave ? last : leave;
  }
  constexpr double kSlack = 1 + 1e-12;  // rounding must not hide a triangle in a flat box
  return enter <= leave * kSlack;
}

}  // namespace

Bvh::Bvh(const TriangleMesh& mesh) : leaf_of_triangle_(mesh.triangles.size()) {
  leaves_.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Corners t = corners(mesh, mesh.triangles[i]);
    leaves_.push_back({t, static_cast<int>(i), is_degenerate(t)});
  }
  build(leaves_.begin(), leaves_.end());
  for (std::size_t i = 0; i < leaves_.size(); ++i) {
    leaf_of_triangle_[static_cast<std::size_t>(leaves_[i].triangle)] = static_cast<int>(i);
  }
}

void Bvh::build(std::vector<Leaf>::iterator begin, std::vector<Leaf>::iterator end) {
  Eigen::AlignedBox3d box, centres;
  for (auto leaf = begin; leaf != end; ++leaf) {
    for (const auto& corner : leaf->corners) box.extend(corner);
    centres.extend(centre(leaf->corners));
  }
  const std::size_t self = nodes_.size();
  nodes_.push_back({box.min(), box.max()});
  if (end - begin <= kTrianglesPerLeaf) {
    nodes_[self].begin = static_cast<int>(begin - leaves_.begin());
    nodes_[self].end = static_cast<int>(end - leaves_.begin());
    return;
  }
  int axis = 0;
  centres.sizes().maxCoeff(&axis);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [axis](const Leaf& a, const Leaf& b) {
    const double along_a = centre(a.corners)[axis], along_b = centre(b.corners)[axis];
    return along_a != along_b ? along_a < along_b : a.triangle < b.triangle;
  });
  build(begin, middle);
  nodes_[self].right = static_cast<int>(nodes_.size());
  build(middle, end);
}

void Bvh::improve(Nearest& best, const Eigen::Vector3d& p, const Leaf& leaf) {
  const TrianglePoint here = leaf.degenerate ? closest_point_on_edges(p, leaf.corners)
                                             : closest_point_on_triangle(p, leaf.corners);
  const double squared = (p - here.point).squaredNorm();
  if (squared < best.squared_distance) best = {here.point, squared, here.feature, leaf.triangle};
}

Bvh::Nearest Bvh::nearest(const Eigen::Vector3d& p, int guess) const {
  Nearest best;
  if (guess >= 0) {
    const auto slot = leaf_of_triangle_.at(static_cast<std::size_t>(guess));
    improve(best, p, leaves_[static_cast<std::size_t>(slot)]);
  }
  struct Entry {
    int node;
    double squared;
  };
  std::array<Entry, kStackSize> stack;
  std::size_t size = 0;
  stack[size++] = {0, squared_distance(p, nodes_[0].low, nodes_[0].high)};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (!(entry.squared < best.squared_distance)) continue;
    const Node& node = nodes_[static_cast<std::size_t>(entry.node)];
    for (int i = node.begin; i < node.end; ++i) {
      improve(best, p, leaves_[static_cast<std::size_t>(i)]);
    }
    if (node.right == 0) continue;
    Entry near{entry.node + 1, 0}, far{node.right, 0};
    const Node& first = nodes_[static_cast<std::size_t>(near.node)];
    const Node& second = nodes_[static_cast<std::size_t>(far.node)];
    near.squared = squared_distance(p, first.low, first.high);
    far.squared = squared_distance(p, second.low, second.high);
    if (far.squared < near.squared) std::swap(near, far);
    if (far.squared < best.squared_distance) stack[size++] = far;
    if (near.squared < best.squared_distance) stack[size++] = near;
  }
  return best;
}

template <typename Visit>
void Bvh::visit_ray(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                    const double& reach, Visit visit) const {
  const Eigen::Vector3d inverse = direction.cwiseInverse();
  std::array<int, kStackSize> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const int index = stack[--size];
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (!ray_meets_box(origin, inverse, node.low, node.high, reach)) continue;
    for (int i = node.begin; i < node.end; ++i) {
      const Leaf& leaf = leaves_[static_cast<std::size_t>(i)];
      const auto distance = line_triangle(origin, direction, leaf.corners);
      if (distance && *distance >= 0 && *distance <= reach) visit(*distance, leaf.triangle);
    }
    if (node.right == 0) continue;
    stack[size++] = node.right;
    stack[size++] = index + 1;
  }
}

std::optional<RayHit> Bvh::first_hit(const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction, double reach) const {
  RayHit best{reach, -1};
  visit_ray(origin, direction, best.distance, [&best](double distance, int triangle) {
    if (best.triangle < 0 || distance < best.distance) best = {distance, triangle};
  });
  if (best.triangle < 0) return std::nullopt;
  return best;
}

int Bvh::count_hits(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  int count = 0;
  visit_ray(origin, direction, std::numeric_limits<double>::infinity(),
            [&count](double, int) { ++count; });
  return count;
}

}  // namespace palpate::geometry
