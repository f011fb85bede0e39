// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/cloud/normals.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <tuple>

#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

/// Neighbours of every point, each edge in both directions.
std::vector<std::vector<int>> neighbour_graph(const KdTree& tree, int neighbours) {
  std::vector<std::vector<int>> graph(tree.points().size());
  for (std::size_t i = 0; i < graph.size(); ++i) {
    for (const auto& n : tree.nearest(tree.points()[i], neighbours)) {
      if (n.index == static_cast<int>(i)) continue;
      graph[i].push_back(n.index);
      graph[static_cast<std::size_t>(n.index)].push_back(static_cast<int>(i));
    }
  }
  return graph;
}

/// Prim's spanning tree from `start`, flipping every normal that turns against its parent's.
void orient_part(const std::vector<std::vector<int>>& graph, std::size_t start,
                 std::vector<Eigen::Vector3d>& normals, std::vector<bool>& done) {
  using Edge = std::tuple<double, int, int>;  // weight, from, to
  std::priority_queue<Edge, std::vector<Edge>, std::greater<>> open;
  const auto visit = [&](std::size_t i) {
    done[i] = true;
    for (const int j : graph[i]) {
      const auto to = static_cast<std::size_t>(j);
      if (!done[to]) open.emplace(1 - std::abs(normals[i].dot(normals[to])), i, j);
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

}  // namespace

std::optional<Eigen::Vector3d> plane_normal(const KdTree& tree, const Eigen::Vector3d& at,
                                            int neighbours) {
  constexpr double kCollinear = 1e-12;  // of the squared extent along the line
  const auto found = tree.nearest(at, neighbours);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& n : found) mean += tree.points()[static_cast<std::size_t>(n.index)];
  mean /= static_cast<double>(found.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& n : found) {
    const Eigen::Vector3d d = tree.points()[static_cast<std::size_t>(n.index)] - mean;
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

std::vector<Eigen::Vector3d> plane_normals(const KdTree& tree, int neighbours) {
  if (neighbours < 3 || tree.points().size() < 3) {
    throw BadInput(fmt::format("no normals from {} neighbours among {} points", neighbours,
                               tree.points().size()));
  }
  std::vector<Eigen::Vector3d> normals;
  for (std::size_t i = 0; i < tree.points().size(); ++i) {
    const auto normal = plane_normal(tree, tree.points()[i], neighbours);
    if (!normal) {
      throw BadInput(
          fmt::format("no normal at point {}: its {} neighbours are collinear", i,
                      std::min(static_cast<std::size_t>(neighbours), tree.points().size())));
    }
    normals.push_back(*normal);
  }
  return normals;
}

void orient_consistently(const KdTree& tree, int neighbours,
                         std::vector<Eigen::Vector3d>& normals) {
  const auto graph = neighbour_graph(tree, neighbours);
  std::vector<std::size_t> by_height(normals.size());
  std::iota(by_height.begin(), by_height.end(), 0);
  const auto& points = tree.points();
  std::ranges::stable_sort(
      by_height, [&](std::size_t a, std::size_t b) { return points[a].z() > points[b].z(); });
  std::vector<bool> done(normals.size(), false);
  for (const std::size_t top : by_height) {
    if (done[top]) continue;
    if (normals[top].z() < 0) normals[top] = -normals[top];
    orient_part(graph, top, normals, done);
  }
}

PointCloud with_normals(PointCloud cloud, int neighbours) {
  cloud.normals.clear();
  check_cloud(cloud);
  const KdTree tree(cloud.points);
  cloud.normals = plane_normals(tree, neighbours);
  orient_consistently(tree, neighbours, cloud.normals);
  return cloud;
}

}  // namespace palpate::geometry
