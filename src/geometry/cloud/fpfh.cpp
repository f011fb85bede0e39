// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/cloud/fpfh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "palpate/core/error.hpp"
#include "palpate/geometry/cloud/kd_tree.hpp"

namespace palpate::geometry {
namespace {

constexpr int kBins = kFpfhBins / 3;

/// The angles of a pair in the Darboux frame of the point whose normal is nearer to the line that
/// joins them; nothing if the line has no length or runs along that normal.
std::optional<Eigen::Vector3d> pair_angles(const PointCloud& cloud, std::size_t i, std::size_t j) {
  Eigen::Vector3d line = cloud.points[j] - cloud.points[i];
  const double length = line.norm();
  if (!(length > 0)) return std::nullopt;
  line /= length;
  Eigen::Vector3d u = cloud.normals[i], other = cloud.normals[j];
  if (std::abs(u.dot(line)) < std::abs(other.dot(line))) {
    std::swap(u, other);
    line = -line;
  }
  const Eigen::Vector3d across = line.cross(u);
  const double sine = across.norm();
  if (!(sine > 0)) return std::nullopt;
  const Eigen::Vector3d v = across / sine, w = u.cross(v);
  return Eigen::Vector3d(std::atan2(w.dot(other), u.dot(other)), v.dot(other), u.dot(line));
}

/// Bin of a share 0..1 of the range.
int bin_of(double share) {
  return std::clamp(static_cast<int>(std::floor(kBins * share)), 0, kBins - 1);
}

/// Nearest neighbours of every point within the radius, without the point itself.
std::vector<std::vector<Neighbour>> neighbourhoods(const PointCloud& cloud, double radius,
                                                   int most) {
  const KdTree tree(cloud.points);
  std::vector<std::vector<Neighbour>> result;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    auto found = tree.nearest(cloud.points[i], most + 1);
    std::erase_if(found, [&](const Neighbour& n) {
      return n.index == static_cast<int>(i) || n.squared_distance >= radius * radius;
    });
    result.push_back(std::move(found));
  }
  return result;
}

/// Histogram of a point's own pairs.
Eigen::Matrix<float, kFpfhBins, 1> simple_histogram(const PointCloud& cloud, std::size_t i,
                                                    const std::vector<Neighbour>& neighbours) {
  Eigen::Matrix<float, kFpfhBins, 1> histogram = Eigen::Matrix<float, kFpfhBins, 1>::Zero();
  const float share = 100.0F / static_cast<float>(std::max<std::size_t>(1, neighbours.size()));
  for (const auto& n : neighbours) {
    const Eigen::Vector3d angles =
        pair_angles(cloud, i, static_cast<std::size_t>(n.index)).value_or(Eigen::Vector3d::Zero());
    histogram[bin_of((angles[0] + std::numbers::pi) / (2 * std::numbers::pi))] += share;
    histogram[kBins + bin_of((angles[1] + 1) / 2)] += share;
    histogram[2 * kBins + bin_of((angles[2] + 1) / 2)] += share;
  }
  return histogram;
}

}  // namespace

Features fpfh(const PointCloud& cloud, double radius, int max_neighbours) {
  check_cloud(cloud);
  if (!(radius > 0)) throw BadInput(fmt::format("feature radius {} m is not positive", radius));
  if (cloud.size() > 0 && !cloud.has_normals()) {
    throw BadInput(fmt::format("no features of {} points without normals", cloud.size()));
  }
  const auto neighbours = neighbourhoods(cloud, radius, max_neighbours);
  Features simple(kFpfhBins, static_cast<Eigen::Index>(cloud.size())), result = simple;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    simple.col(static_cast<Eigen::Index>(i)) = simple_histogram(cloud, i, neighbours[i]);
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Eigen::Matrix<float, kFpfhBins, 1> sum = Eigen::Matrix<float, kFpfhBins, 1>::Zero();
    for (const auto& n : neighbours[i]) {
      if (n.squared_distance > 0) {
        sum += simple.col(n.index) / static_cast<float>(n.squared_distance);
      }
    }
    for (int part = 0; part < 3; ++part) {
      auto bins = sum.segment<kBins>(part * kBins);
      if (bins.sum() > 0) bins *= 100 / bins.sum();
    }
    result.col(static_cast<Eigen::Index>(i)) = simple.col(static_cast<Eigen::Index>(i)) + sum;
  }
  return result;
}

std::vector<Match> mutual_matches(const Features& source, const Features& target) {
  constexpr Eigen::Index kBlock = 256;
  if (source.cols() == 0 || target.cols() == 0) return {};
  const Eigen::RowVectorXf target_norms = target.colwise().squaredNorm();
  const Eigen::VectorXf source_norms = source.colwise().squaredNorm().transpose();
  std::vector<Eigen::Index> best_source(static_cast<std::size_t>(target.cols()), -1),
      best_target(static_cast<std::size_t>(source.cols()), -1);
  Eigen::RowVectorXf least = Eigen::RowVectorXf::Constant(target.cols(), INFINITY);
  for (Eigen::Index start = 0; start < source.cols(); start += kBlock) {
    const Eigen::Index rows = std::min(kBlock, source.cols() - start);
    Eigen::MatrixXf distances = -2 * (source.middleCols(start, rows).transpose() * target);
    distances.rowwise() += target_norms;
    distances.colwise() += source_norms.segment(start, rows);
    // Column by column, as the matrix lies in memory.
    Eigen::ArrayXf nearest = Eigen::ArrayXf::Constant(rows, INFINITY);
    for (Eigen::Index j = 0; j < target.cols(); ++j) {
      for (Eigen::Index i = 0; i < rows; ++i) {
        if (!(distances(i, j) < nearest[i])) continue;
        nearest[i] = distances(i, j);
        best_target[static_cast<std::size_t>(start + i)] = j;
      }
      Eigen::Index i = 0;
      const float distance = distances.col(j).minCoeff(&i);
      if (!(distance < least[j])) continue;
      least[j] = distance;
      best_source[static_cast<std::size_t>(j)] = start + i;
    }
  }
  std::vector<Match> matches;
  for (std::size_t i = 0; i < best_target.size(); ++i) {
    if (best_target[i] < 0) continue;
    const auto j = static_cast<std::size_t>(best_target[i]);
    if (best_source[j] == static_cast<Eigen::Index>(i)) {
      matches.push_back({static_cast<int>(i), static_cast<int>(j)});
    }
  }
  return matches;
}

}  // namespace palpate::geometry
