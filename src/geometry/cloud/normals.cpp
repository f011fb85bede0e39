// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/cloud/normals.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>
#include <span>
#include <tuple>

#include "geometry/cloud/parallel_blocks.hpp"
#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

/// Lists of points' indices, one after another.
struct Lists {
  std::span<const int> operator[](std::size_t i) const {
    return {indices.data() + starts[i], indices.data() + starts[i + 1]};
  }
  std::size_t size() const { return starts.size() - 1; }

  std::vector<int> indices;
  std::vector<std::size_t> starts = {0};  // and the end
};

/// Of every point its nearest ones, itself among them.
Lists nearest_lists(const KdTree& tree, int neighbours, int threads) {
  const std::size_t points = tree.points().size();
  if (neighbours < 3 || points < 3) {
    throw BadInput(
        fmt::format("no normals from {} neighbours among {} points", neighbours, points));
  }
  const std::size_t each = std::min(points, static_cast<std::size_t>(neighbours));
  Lists lists{std::vector<int>(each * points), std::vector<std::size_t>(points + 1)};
  for (std::size_t i = 0; i <= points; ++i) lists.starts[i] = each * i;
  parallel_ranges(points, threads, [&](std::size_t first, std::size_t end) {
    std::vector<Neighbour> found;
    for (std::size_t i = first; i < end; ++i) {
      tree.find_nearest(tree.points()[i], neighbours, found);
      found.resize(each, {static_cast<int>(i), 0});  // squares of distances may be too large
      for (std::size_t k = 0; k < each; ++k) lists.indices[each * i + k] = found[k].index;
    }
  });
  return lists;
}

/// Each edge in both directions.
Lists graph_of(const Lists& lists) {
  Lists graph;
  graph.starts.assign(lists.size() + 1, 0);
  const auto for_each_end = [&](const auto& visit) {
    for (std::size_t i = 0; i < lists.size(); ++i) {
      for (const int j : lists[i]) {
        if (j == static_cast<int>(i)) continue;
        visit(i, j);
        visit(static_cast<std::size_t>(j), static_cast<int>(i));
      }
    }
  };
  for_each_end([&](std::size_t from, int) { ++graph.starts[from + 1]; });
  std::partial_sum(graph.starts.begin(), graph.starts.end(), graph.starts.begin());
  graph.indices.resize(graph.starts.back());
  std::vector<std::size_t> next = graph.starts;
  for_each_end([&](std::size_t from, int to) { graph.indices[next[from]++] = to; });
  return graph;
}

std::optional<Eigen::Vector3d> fitted_normal(const std::vector<Eigen::Vector3d>& points,
                                             std::span<const int> indices) {
  constexpr double kCollinear = 1e-12;  // of the squared extent along the line
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const int i : indices) mean += points[static_cast<std::size_t>(i)];
  mean /= static_cast<double>(indices.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const int i : indices) {
    const Eigen::Vector3d d = points[static_cast<std::size_t>(i)] - mean;
    covariance += d * d.transpose();
  }
  // The sum of the principal minors is that of the products of two eigenvalues.
  const double trace = covariance.trace();
  const double products = (trace * trace - covariance.squaredNorm()) / 2;
  if (!(products > kCollinear * trace * trace)) return std::nullopt;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(covariance / trace);
  return eigen.eigenvectors().col(0);
}

/// 0 where the neighbours are collinear.
std::vector<Eigen::Vector3d> fitted_normals(const std::vector<Eigen::Vector3d>& points,
                                            const Lists& lists, int threads) {
  std::vector<Eigen::Vector3d> normals(points.size());
  parallel_blocks(points.size(), threads, [&](std::size_t i) {
    normals[i] = fitted_normal(points, lists[i]).value_or(Eigen::Vector3d::Zero());
  });
  return normals;
}

void check_fitted(const std::vector<Eigen::Vector3d>& normals, const Lists& lists) {
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!normals[i].isZero(0)) continue;
    throw BadInput(
        fmt::format("no normal at point {}: its {} neighbours are collinear", i, lists[i].size()));
  }
}

/// Prim's spanning tree from `start`, flipping every normal that turns against its parent's.
/// @param least  for each point weight and start of the least of the open edges to it, which alone
///               matters
void orient_part(const Lists& graph, std::size_t start, std::vector<Eigen::Vector3d>& normals,
                 std::vector<bool>& done, std::vector<std::pair<double, int>>& least) {
  using Edge = std::tuple<double, int, int>;  // weight, from, to
  std::priority_queue<Edge, std::vector<Edge>, std::greater<>> open;
  const auto visit = [&](std::size_t i) {
    done[i] = true;
    for (const int j : graph[i]) {
      const auto to = static_cast<std::size_t>(j);
      if (done[to]) continue;
      const std::pair edge(1 - std::abs(normals[i].dot(normals[to])), static_cast<int>(i));
      if (edge >= least[to]) continue;
      least[to] = edge;
      open.emplace(edge.first, edge.second, j);
    }
  };
  visit(start);
  while (!open.empty()) {
    const auto [weight, from, to] = open.top();
    open.pop();
    const auto i = static_cast<std::size_t>(from), j = static_cast<std::size_t>(to);
    if (done[j]) continue;
    if (normals[i].dot(normals[j]) < 0) normals[j] = -normals[j];
    visit(j);
  }
}

/// Flips normals so that they agree along a minimum spanning tree of the neighbours' graph with
/// weights 1 - |n_i . n_j|, each part of it pointing outward at its highest point (Hoppe et al.
/// 1992, 3.3).
void orient_consistently(const std::vector<Eigen::Vector3d>& points, const Lists& graph,
                         std::vector<Eigen::Vector3d>& normals) {
  std::vector<std::size_t> by_height(normals.size());
  std::iota(by_height.begin(), by_height.end(), 0);
  std::ranges::stable_sort(
      by_height, [&](std::size_t a, std::size_t b) { return points[a].z() > points[b].z(); });
  std::vector<bool> done(normals.size(), false);
  std::vector least(normals.size(), std::pair(std::numeric_limits<double>::infinity(), 0));
  for (const std::size_t top : by_height) {
    if (done[top]) continue;
    if (normals[top].z() < 0) normals[top] = -normals[top];
    orient_part(graph, top, normals, done, least);
  }
}

}  // namespace

std::optional<Eigen::Vector3d> plane_normal(const KdTree& tree, const Eigen::Vector3d& at,
                                            int neighbours) {
  std::vector<int> indices;
  for (const auto& n : tree.nearest(at, neighbours)) indices.push_back(n.index);
  return fitted_normal(tree.points(), indices);
}

namespace {

/// Fits the normals, of either sign; without points that have none, the others' neighbours change.
/// @return the neighbours
Lists fit_normals(PointCloud& cloud, int neighbours, int threads, CollinearPoints collinear) {
  cloud.normals.clear();
  check_cloud(cloud);
  for (;;) {
    const Lists lists = nearest_lists(KdTree(cloud.points), neighbours, threads);
    auto normals = fitted_normals(cloud.points, lists, threads);
    if (collinear == CollinearPoints::kRefuse) check_fitted(normals, lists);
    std::vector<int> kept;
    for (std::size_t i = 0; i < normals.size(); ++i) {
      if (!normals[i].isZero(0)) kept.push_back(static_cast<int>(i));
    }
    if (kept.size() == normals.size()) {
      cloud.normals = std::move(normals);
      return lists;
    }
    cloud = subset(cloud, kept);
    if (cloud.size() < 3) return {};
  }
}

}  // namespace

PointCloud with_plane_normals(PointCloud cloud, int neighbours, int threads,
                              CollinearPoints collinear) {
  fit_normals(cloud, neighbours, threads, collinear);
  return cloud.has_normals() ? cloud : PointCloud{};
}

PointCloud with_normals(PointCloud cloud, int neighbours, int threads, CollinearPoints collinear) {
  const Lists lists = fit_normals(cloud, neighbours, threads, collinear);
  if (!cloud.has_normals()) return {};
  orient_consistently(cloud.points, graph_of(lists), cloud.normals);
  return cloud;
}

}  // namespace palpate::geometry
