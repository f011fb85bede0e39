// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "geometry/mesh/triangle.hpp"
#include "palpate/geometry/query/mesh_query.hpp"

namespace palpate::geometry {

/// Bounding-volume tree over a mesh's triangles: median splits along the longest axis, so that its
/// depth is bounded; nodes in depth-first order.
class Bvh {
 public:
  struct Nearest {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    double squared_distance = std::numeric_limits<double>::infinity();
    Feature feature = Feature::kFace;
    int triangle = -1;
  };

  explicit Bvh(const TriangleMesh& mesh);

  /// Nearest point over all triangles. `guess` (a triangle, or -1) is looked at first.
  Nearest nearest(const Eigen::Vector3d& p, int guess) const;

  /// First triangle along the ray; direction of unit length.
  std::optional<RayHit> first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                  double reach) const;

  /// Number of triangles along the whole ray.
  int count_hits(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  /// Calls visit(triangle) for every triangle that may meet the box (and a few more).
  template <typename Visit>
  void visit_box(const Eigen::AlignedBox3d& box, Visit visit) const {
    visit_box(box, 0, visit);
  }

 private:
  struct Node {
    Eigen::Vector3d low, high;
    int right = 0;           // inner node: index of the second child (the first follows its parent)
    int begin = 0, end = 0;  // leaf: range of leaves_
  };
  struct Leaf {
    Corners corners;
    int triangle = -1;
    bool degenerate = false;
  };

  void build(std::vector<Leaf>::iterator begin, std::vector<Leaf>::iterator end);
  static void improve(Nearest& best, const Eigen::Vector3d& p, const Leaf& leaf);

  template <typename Visit>
  void visit_box(const Eigen::AlignedBox3d& box, int index, Visit& visit) const {
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (!box.intersects(Eigen::AlignedBox3d(node.low, node.high))) return;
    for (int i = node.begin; i < node.end; ++i)
      visit(leaves_[static_cast<std::size_t>(i)].triangle);
    if (node.right == 0) return;
    visit_box(box, index + 1, visit);
    visit_box(box, node.right, visit);
  }

  template <typename Visit>
  void visit_ray(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                 const double& reach, Visit visit) const;

  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
  std::vector<int> leaf_of_triangle_;
};

}  // namespace palpate::geometry
