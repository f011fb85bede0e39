// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/cloud/fpfh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>

#include "geometry/cloud/parallel_blocks.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/cloud/kd_tree.hpp"

namespace palpate::geometry {
namespace {

constexpr int kBins = kFpfhBins / 3;

using Histogram = Eigen::Matrix<float, kFpfhBins, 1>;

/// Bins of theta, alpha and phi, small as there are many.
struct PairBins {
  PairBins(int theta_bin, int alpha_bin, int phi_bin, bool same)
      : theta(static_cast<std::uint8_t>(theta_bin)),
        alpha(static_cast<std::uint8_t>(alpha_bin)),
        phi(static_cast<std::uint8_t>(phi_bin)),
        both_ways(same) {}

  std::uint8_t theta, alpha, phi;
  bool both_ways;  ///< the same seen from either point
};

/// Bin of a share 0..1 of the range.
int bin_of(double share) {
  return std::clamp(static_cast<int>(std::floor(kBins * share)), 0, kBins - 1);
}

/// Directions of the edges between the bins of an angle of -pi..pi, but for the first.
const std::array<Eigen::Vector2d, kBins - 1>& bin_edges() {
  static const auto kEdges = [] {
    std::array<Eigen::Vector2d, kBins - 1> edges;
    for (int k = 1; k < kBins; ++k) {
      const double angle = (2.0 * k / kBins - 1) * std::numbers::pi;
      edges[static_cast<std::size_t>(k - 1)] = {std::cos(angle), std::sin(angle)};
    }
    return edges;
  }();
  return kEdges;
}

/// Bin of the angle atan2(y, x), by the edges that the direction is past.
int bin_of_angle(double y, double x) {
  static_assert(kBins % 2 == 1);
  constexpr std::size_t kHalf = kBins / 2;
  const auto& edges = bin_edges();
  const std::size_t first = y < 0 ? 0 : kHalf;
  int bin = static_cast<int>(first);
  for (std::size_t k = first; k < first + kHalf; ++k) {
    bin += edges[k].x() * y - edges[k].y() * x >= 0;
  }
  return bin;
}

const PairBins kUndefined(kBins / 2, kBins / 2, kBins / 2, true);  // of angles that are 0

/// The angles of a pair in the Darboux frame of the point whose normal is nearer to the line that
/// joins them; undefined if the line has no length or runs along that normal.
PairBins pair_bins(const PointCloud& cloud, std::size_t i, std::size_t j) {
  Eigen::Vector3d line = cloud.points[j] - cloud.points[i];
  const double length = line.norm();
  if (!(length > 0)) return kUndefined;
  line /= length;
  const Eigen::Vector3d *u = &cloud.normals[i], *other = &cloud.normals[j];
  double phi = u->dot(line), turned = -other->dot(line);
  if (std::abs(phi) < std::abs(turned)) {
    std::swap(u, other);
    line = -line;
    std::swap(phi, turned);
  }
  const bool both_ways = std::abs(phi) != std::abs(turned);
  const Eigen::Vector3d across = line.cross(*u);
  const double sine = across.norm();
  if (!(sine > 0)) return kUndefined;
  // With v = across / sine and w = u x v: sine w = line - phi u.
  const double along = u->dot(*other);
  return {bin_of_angle(line.dot(*other) - phi * along, sine * along),
          bin_of((across.dot(*other) / sine + 1) / 2), bin_of((phi + 1) / 2), both_ways};
}

/// Of a point without itself, as far as its squared reach.
struct Neighbourhood {
  std::vector<Neighbour> neighbours;
  double squared_reach = 0;
};

/// Keeps the nearest `count` and those as near as the last of them.
/// @return that distance, squared, or `squared_radius` if there are no more
double keep_nearest(std::vector<Neighbour>& found, std::size_t count, double squared_radius) {
  if (found.size() <= count) return squared_radius;
  const auto last = found.begin() + static_cast<std::ptrdiff_t>(count - 1);
  std::ranges::nth_element(found, last, {}, &Neighbour::squared_distance);
  const double squared = last->squared_distance;
  std::erase_if(found, [&](const Neighbour& n) { return n.squared_distance > squared; });
  return squared;
}

/// Neighbours of every point within the radius: the nearest, and those as near as the last of them.
std::vector<Neighbourhood> neighbourhoods(const PointCloud& cloud, double radius, int most,
                                          int threads) {
  const KdTree tree(cloud.points);
  std::vector<Neighbourhood> result(cloud.size());
  const auto count = static_cast<std::size_t>(std::max(1, most));
  parallel_ranges(cloud.size(), threads, [&](std::size_t first, std::size_t end) {
    std::vector<Neighbour> found;  // far more than are kept
    for (std::size_t i = first; i < end; ++i) {
      tree.find_within(cloud.points[i], radius, found);
      std::erase_if(found, [&](const Neighbour& n) { return n.index == static_cast<int>(i); });
      result[i].squared_reach = keep_nearest(found, count, radius * radius);
      result[i].neighbours.assign(found.begin(), found.end());
    }
  });
  return result;
}

using Histograms = Eigen::Matrix<float, kFpfhBins, Eigen::Dynamic>;

/// A pair as both of its points see it; the other way round only where the neighbourhood is mutual.
struct SeenPair {
  int other;
  PairBins bins;
  std::optional<PairBins> backwards;
};

/// The pairs of point i, those with both points in each other's neighbourhood at the first alone.
std::vector<SeenPair> pairs_of(const PointCloud& cloud, const std::vector<Neighbourhood>& around,
                               std::size_t i) {
  std::vector<SeenPair> pairs;
  pairs.reserve(around[i].neighbours.size());
  for (const auto& n : around[i].neighbours) {
    const auto j = static_cast<std::size_t>(n.index);
    const bool mutual = n.squared_distance <= around[j].squared_reach;
    if (mutual && j < i) continue;
    SeenPair pair{n.index, pair_bins(cloud, i, j), std::nullopt};
    if (mutual) pair.backwards = pair.bins.both_ways ? pair.bins : pair_bins(cloud, j, i);
    pairs.push_back(pair);
  }
  return pairs;
}

/// Histograms of the points' own pairs, each pair looked at once for both.
Histograms simple_histograms(const PointCloud& cloud, const std::vector<Neighbourhood>& around,
                             int threads) {
  std::vector<std::vector<SeenPair>> pairs(cloud.size());
  parallel_blocks(cloud.size(), threads,
                  [&](std::size_t i) { pairs[i] = pairs_of(cloud, around, i); });
  Histograms histograms = Histograms::Zero(kFpfhBins, static_cast<Eigen::Index>(cloud.size()));
  const auto add = [&](std::size_t i, const PairBins& bins) {
    const float share = 100.0F / static_cast<float>(around[i].neighbours.size());
    float* histogram = histograms.col(static_cast<Eigen::Index>(i)).data();
    histogram[bins.theta] += share;
    histogram[kBins + bins.alpha] += share;
    histogram[2 * kBins + bins.phi] += share;
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (const SeenPair& pair : pairs[i]) {
      add(i, pair.bins);
      if (pair.backwards) add(static_cast<std::size_t>(pair.other), *pair.backwards);
    }
  }
  return histograms;
}

/// Turns the histograms of one angle round.
void reverse_bins(int part, Features& features) {
  auto bins = features.middleRows(part * kBins, kBins);
  bins = bins.colwise().reverse().eval();
}

}  // namespace

Features fpfh(const PointCloud& cloud, double radius, int max_neighbours, int threads) {
  check_cloud(cloud);
  if (!(radius > 0)) throw BadInput(fmt::format("feature radius {} m is not positive", radius));
  if (cloud.size() > 0 && !cloud.has_normals()) {
    throw BadInput(fmt::format("no features of {} points without normals", cloud.size()));
  }
  const auto around = neighbourhoods(cloud, radius, max_neighbours, threads);
  const Histograms simple = simple_histograms(cloud, around, threads);
  Features result(kFpfhBins, static_cast<Eigen::Index>(cloud.size()));
  parallel_blocks(cloud.size(), threads, [&](std::size_t i) {
    Histogram sum = Histogram::Zero();
    for (const auto& n : around[i].neighbours) {
      if (n.squared_distance > 0) {
        sum += simple.col(n.index) * static_cast<float>(1 / n.squared_distance);
      }
    }
    for (int part = 0; part < 3; ++part) {
      auto bins = sum.segment<kBins>(part * kBins);
      if (bins.sum() > 0) bins *= 100 / bins.sum();
    }
    result.col(static_cast<Eigen::Index>(i)) = simple.col(static_cast<Eigen::Index>(i)) + sum;
  });
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

}  // namespace palpate::geometry
