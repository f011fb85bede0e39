// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

namespace palpate::geometry {

struct Neighbour {
  int index = -1;
  double squared_distance = 0;  ///< m^2
};

/// Nearest points of a fixed set. Immutable after construction, so that threads may share it.
class KdTree {
 public:
  /// @throws BadInput for a point that is not finite
  explicit KdTree(std::vector<Eigen::Vector3d> points);
  ~KdTree();
  KdTree(KdTree&&) noexcept;
  KdTree& operator=(KdTree&&) noexcept;

  const std::vector<Eigen::Vector3d>& points() const;

  /// The k nearest points (all, if there are fewer), nearest first; of equally near ones any.
  std::vector<Neighbour> nearest(const Eigen::Vector3d& query, int k) const;

  /// The same into a list whose memory is used again.
  void find_nearest(const Eigen::Vector3d& query, int k, std::vector<Neighbour>& found) const;

  /// The nearest point, if it is closer than the radius; else index -1. Allocates nothing.
  Neighbour nearest_within(const Eigen::Vector3d& query, double radius) const;

  /// All points closer than the radius, nearest first, equally near ones by index.
  std::vector<Neighbour> within(const Eigen::Vector3d& query, double radius) const;

  /// The same in no order, into a list whose memory is used again.
  void find_within(const Eigen::Vector3d& query, double radius,
                   std::vector<Neighbour>& found) const;

 private:
  struct Index;
  std::unique_ptr<const Index> index_;
};

}  // namespace palpate::geometry
