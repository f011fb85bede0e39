// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/cloud/fpfh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"
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

/// Turns the histograms of one angle round.
void reverse_bins(int part, Features& features) {
  auto bins = features.middleRows<kBins>(part * kBins);
  bins = bins.colwise().reverse().eval();
}

/// For each column the nearest one of another set, the first of equals, as far as was looked.
struct Nearest {
  explicit Nearest(Eigen::Index columns)
      : distances(Eigen::ArrayXf::Constant(columns, INFINITY)),
        indices(static_cast<std::size_t>(columns), -1) {}

  Eigen::ArrayXf distances;
  std::vector<Eigen::Index> indices;
};

constexpr Eigen::Index kChunk = 512;  // targets that one thread looks at

/// All sources against the targets from `first` on, a chunk of them.
void find_nearest(const Features& source, const Features& target, Eigen::Index first,
                  Nearest& of_sources, Nearest& of_targets) {
  constexpr Eigen::Index kBlock = 256;
  const Eigen::Index columns = std::min(kChunk, target.cols() - first);
  const Eigen::RowVectorXf target_norms = target.middleCols(first, columns).colwise().squaredNorm();
  for (Eigen::Index start = 0; start < source.cols(); start += kBlock) {
    const Eigen::Index rows = std::min(kBlock, source.cols() - start);
    const auto block = source.middleCols(start, rows);
    Eigen::MatrixXf distances = -2 * (block.transpose() * target.middleCols(first, columns));
    distances.rowwise() += target_norms;
    distances.colwise() += block.colwise().squaredNorm().transpose();
    // Column by column, as the matrix lies in memory.
    for (Eigen::Index j = 0; j < columns; ++j) {
      for (Eigen::Index i = 0; i < rows; ++i) {
        if (!(distances(i, j) < of_sources.distances[start + i])) continue;
        of_sources.distances[start + i] = distances(i, j);
        of_sources.indices[static_cast<std::size_t>(start + i)] = first + j;
      }
      Eigen::Index i = 0;
      const float distance = distances.col(j).minCoeff(&i);
      if (!(distance < of_targets.distances[first + j])) continue;
      of_targets.distances[first + j] = distance;
      of_targets.indices[static_cast<std::size_t>(first + j)] = start + i;
    }
  }
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

Features turned_inside_out(Features features) {
  for (const int part : {0, 2}) reverse_bins(part, features);
  return features;
}

Features mirrored(Features features) {
  reverse_bins(1, features);
  return features;
}

std::vector<Match> mutual_matches(const Features& source, const Features& target, int threads) {
  if (source.cols() == 0 || target.cols() == 0) return {};
  const auto chunks = static_cast<std::size_t>((target.cols() + kChunk - 1) / kChunk);
  std::vector<Nearest> of_sources(chunks, Nearest(source.cols()));
  Nearest of_targets(target.cols());
  parallel_for(chunks, threads, [&](std::size_t k) {
    find_nearest(source, target, static_cast<Eigen::Index>(k) * kChunk, of_sources[k], of_targets);
  });
  std::vector<Match> matches;
  for (Eigen::Index i = 0; i < source.cols(); ++i) {
    const auto& best = *std::ranges::min_element(
        of_sources, {}, [i](const Nearest& chunk) { return chunk.distances[i]; });
    const Eigen::Index j = best.indices[static_cast<std::size_t>(i)];
    if (j >= 0 && of_targets.indices[static_cast<std::size_t>(j)] == i) {
      matches.push_back({static_cast<int>(i), static_cast<int>(j)});
    }
  }
  return matches;
}

}  // namespace palpate::geometry
