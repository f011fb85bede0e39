// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/cloud/kd_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nanoflann.hpp>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

/// What nanoflann asks of a set of points.
struct Points {
  std::vector<Eigen::Vector3d> list;

  std::size_t kdtree_get_point_count() const { return list.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return list[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>,
                                                 Points, 3, int>;

/// What nanoflann asks of a list of results.
struct Collector {
  double squared_radius;
  std::vector<Neighbour>& found;

  void init() { found.clear(); }
  void clear() { found.clear(); }
  std::size_t size() const { return found.size(); }
  bool full() const { return true; }
  bool addPoint(double squared, int index) {
    if (squared < squared_radius) found.push_back({index, squared});
    return true;
  }
  double worstDist() const { return squared_radius; }
};

/// The nearest ones so far, nearest first.
struct NearestCollector {
  std::size_t most;
  std::vector<Neighbour>& found;

  std::size_t size() const { return found.size(); }
  bool full() const { return found.size() == most; }
  bool addPoint(double squared, int index) {
    if (squared >= worstDist()) return true;
    if (!full()) found.emplace_back();
    auto at = found.end() - 1;
    for (; at != found.begin() && (at - 1)->squared_distance > squared; --at) *at = *(at - 1);
    *at = {index, squared};
    return true;
  }
  double worstDist() const {
    return full() ? found.back().squared_distance : std::numeric_limits<double>::max();
  }
};

bool is_nearer(const Neighbour& a, const Neighbour& b) {
  return a.squared_distance < b.squared_distance;
}

/// The same for many, which are put in order now and then.
struct ManyNearestCollector {
  std::size_t most;
  std::vector<Neighbour>& found;
  double worst = std::numeric_limits<double>::max();

  std::size_t size() const { return std::min(most, found.size()); }
  bool full() const { return found.size() >= most; }
  bool addPoint(double squared, int index) {
    if (squared >= worst) return true;
    found.push_back({index, squared});
    if (found.size() >= most + most / 2) prune();
    return true;
  }
  double worstDist() const { return worst; }

  /// Leaves the nearest ones.
  void prune() {
    if (found.size() <= most) return;
    const auto last = found.begin() + static_cast<std::ptrdiff_t>(most) - 1;
    std::ranges::nth_element(found, last, is_nearer);
    worst = last->squared_distance;
    found.resize(most);
  }
};

}  // namespace

struct KdTree::Index {
  explicit Index(std::vector<Eigen::Vector3d> list) : points{std::move(list)}, tree(3, points) {}

  Points points;
  Tree tree;
};

KdTree::KdTree(std::vector<Eigen::Vector3d> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) throw BadInput(fmt::format("point {} is not finite", i));
  }
  index_ = std::make_unique<const Index>(std::move(points));
}

KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;
KdTree& KdTree::operator=(KdTree&&) noexcept = default;

const std::vector<Eigen::Vector3d>& KdTree::points() const { return index_->points.list; }

std::vector<Neighbour> KdTree::nearest(const Eigen::Vector3d& query, int k) const {
  std::vector<Neighbour> found;
  find_nearest(query, k, found);
  return found;
}

void KdTree::find_nearest(const Eigen::Vector3d& query, int k,
                          std::vector<Neighbour>& found) const {
  found.clear();
  const auto most = std::min(static_cast<std::size_t>(std::max(0, k)), points().size());
  if (most == 0) return;
  found.reserve(most);
  constexpr std::size_t kMany = 256;  // to insert one takes moving half of them
  if (most > kMany) {
    ManyNearestCollector collector{most, found};
    index_->tree.findNeighbors(collector, query.data(), nanoflann::SearchParams());
    collector.prune();
    std::ranges::sort(found, is_nearer);
    return;
  }
  NearestCollector collector{most, found};
  index_->tree.findNeighbors(collector, query.data(), nanoflann::SearchParams());
}

Neighbour KdTree::nearest_within(const Eigen::Vector3d& query, double radius) const {
  Neighbour found;
  if (points().empty()) return found;
  // The list starts with the radius as its worst entry, so that the search prunes by it.
  int index = -1;
  double squared = radius * radius;
  nanoflann::KNNResultSet<double, int> nearest(1);
  nearest.init(&index, &squared);
  squared = radius * radius;
  index_->tree.findNeighbors(nearest, query.data(), nanoflann::SearchParams());
  if (nearest.size() > 0 && squared < radius * radius) found = {index, squared};
  return found;
}

std::vector<Neighbour> KdTree::within(const Eigen::Vector3d& query, double radius) const {
  std::vector<Neighbour> found;
  find_within(query, radius, found);
  std::ranges::sort(found, [](const Neighbour& a, const Neighbour& b) {
    return std::pair(a.squared_distance, a.index) < std::pair(b.squared_distance, b.index);
  });
  return found;
}

void KdTree::find_within(const Eigen::Vector3d& query, double radius,
                         std::vector<Neighbour>& found) const {
  found.clear();
  if (points().empty() || !(radius > 0)) return;
  Collector collector{radius * radius, found};
  index_->tree.findNeighbors(collector, query.data(), nanoflann::SearchParams());
}

}  // namespace palpate::geometry
