// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/cloud/point_cloud.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

struct Cell {
  std::int64_t x, y, z;

  bool operator==(const Cell&) const = default;
};

struct CellHash {
  std::size_t operator()(const Cell& cell) const {
    std::uint64_t hash = 0;
    for (const std::int64_t k : {cell.x, cell.y, cell.z}) {
      hash = (hash ^ static_cast<std::uint64_t>(k)) * 0x9e3779b97f4a7c15;
      hash ^= hash >> 29;
    }
    return hash;
  }
};

/// Numbers cubes from 0 as they are first met, by open addressing: a fraction of the time of a node
/// for each.
class CellNumbers {
 public:
  explicit CellNumbers(std::size_t most) {
    while (slots_.size() < 2 * most + 2)
      slots_.resize(2 * std::max<std::size_t>(8, slots_.size()), kFree);
  }

  std::size_t number(const Cell& cell) {
    std::size_t slot = CellHash{}(cell) & (slots_.size() - 1);
    while (slots_[slot] != kFree && cells_[slots_[slot]] != cell) {
      slot = (slot + 1) & (slots_.size() - 1);
    }
    if (slots_[slot] == kFree) {
      slots_[slot] = static_cast<std::uint32_t>(cells_.size());
      cells_.push_back(cell);
    }
    return slots_[slot];
  }

  std::size_t count() const { return cells_.size(); }

 private:
  static constexpr std::uint32_t kFree = 0xffffffff;
  std::vector<std::uint32_t> slots_;
  std::vector<Cell> cells_;
};

Eigen::AlignedBox3d box_of(const PointView& cloud) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < cloud.size(); ++i) box.extend(cloud.point(i));
  return box;
}

Cell cell_at(const Eigen::Vector3d& p, const Eigen::Vector3d& low, double cell) {
  const Eigen::Vector3d k = (p - low) / cell;  // none below 0
  return {static_cast<std::int64_t>(k[0]), static_cast<std::int64_t>(k[1]),
          static_cast<std::int64_t>(k[2])};
}

/// For each point the number of its cube, counted from 0 as they are first met.
std::vector<std::size_t> cells_of(const PointView& cloud, double cell, std::size_t& count) {
  const Eigen::Vector3d low = box_of(cloud).min();
  CellNumbers numbers(cloud.size());
  std::vector<std::size_t> result;
  result.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    result.push_back(numbers.number(cell_at(cloud.point(i), low, cell)));
  }
  count = numbers.count();
  return result;
}

/// Counts cubes whose numbers along each axis are below 1024.
class CellCounter {
 public:
  explicit CellCounter(std::size_t most) : slots_(std::bit_ceil(2 * most + 2)) {}

  void clear() {
    std::ranges::fill(slots_, kFree);
    count_ = 0;
  }

  void add(const Cell& cell) {
    const auto key = static_cast<std::uint32_t>(cell.x << 20 | cell.y << 10 | cell.z);
    std::size_t slot = (key * 0x9e3779b97f4a7c15 >> 20) & (slots_.size() - 1);
    while (slots_[slot] != kFree && slots_[slot] != key) slot = (slot + 1) & (slots_.size() - 1);
    count_ += slots_[slot] == kFree;
    slots_[slot] = key;
  }

  std::size_t count() const { return count_; }

 private:
  static constexpr std::uint32_t kFree = 0xffffffff;
  std::vector<std::uint32_t> slots_;
  std::size_t count_ = 0;
};

/// Smallest cell from `cell` on, to a few per cent, that leaves at most `most` of every stride-th
/// point.
/// @param cell  at least a thousandth of the box's diagonal
double cell_from(const PointView& cloud, std::size_t stride, const Eigen::Vector3d& low,
                 std::size_t most, double cell) {
  constexpr double kMinStep = 1.02;
  CellCounter cells(cloud.size() / stride + 1);
  for (;;) {
    cells.clear();
    for (std::size_t i = 0; i < cloud.size(); i += stride) {
      cells.add(cell_at(cloud.point(i), low, cell));
    }
    if (cells.count() <= most) return cell;
    // A surface: the number falls with the square of the cell.
    const double excess = static_cast<double>(cells.count()) / static_cast<double>(most);
    cell *= std::max(kMinStep, std::sqrt(excess));
  }
}

}  // namespace

PointView::PointView(const PointCloud& cloud)
    : PointView(cloud.points.empty() ? nullptr : cloud.points.front().data(), cloud.size()) {
  if (!cloud.has_normals()) return;
  if (cloud.normals.size() != cloud.size()) {
    throw BadInput(fmt::format("{} normals for {} points", cloud.normals.size(), cloud.size()));
  }
  *this = with_normals(cloud.normals.front().data(), stride_);
}

PointView::PointView(const double* points, std::size_t count, std::ptrdiff_t stride)
    : points_(reinterpret_cast<const std::byte*>(points)), size_(count), stride_(stride) {}

PointView::PointView(const float* points, std::size_t count, std::ptrdiff_t stride)
    : points_(reinterpret_cast<const std::byte*>(points)),
      size_(count),
      stride_(stride),
      is_float_(true) {}

PointView PointView::with_normals(const void* normals, std::ptrdiff_t stride) const {
  PointView result = *this;
  result.normals_ = static_cast<const std::byte*>(normals);
  result.normal_stride_ = stride;
  return result;
}

PointCloud copied(const PointView& view) {
  PointCloud cloud;
  for (std::size_t i = 0; i < view.size(); ++i) {
    cloud.points.push_back(view.point(i));
    if (view.has_normals()) cloud.normals.push_back(view.normal(i));
  }
  return cloud;
}

void check_cloud(const PointView& cloud) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = cloud.point(i);
    if (!p.allFinite()) {
      throw BadInput(fmt::format("point {} is not finite: ({}, {}, {})", i, p[0], p[1], p[2]));
    }
    if (cloud.has_normals() && !(std::abs(cloud.normal(i).norm() - 1) < 1e-3)) {
      throw BadInput(fmt::format("normal {} has length {}", i, cloud.normal(i).norm()));
    }
  }
}

PointCloud subset(const PointCloud& cloud, const std::vector<int>& indices) {
  PointCloud result;
  for (const int i : indices) {
    result.points.push_back(cloud.points[static_cast<std::size_t>(i)]);
    if (cloud.has_normals()) result.normals.push_back(cloud.normals[static_cast<std::size_t>(i)]);
  }
  return result;
}

PointCloud transformed(const Eigen::Isometry3d& T, PointCloud cloud) {
  for (auto& p : cloud.points) p = T * p;
  for (auto& n : cloud.normals) n = T.linear() * n;
  return cloud;
}

PointCloud voxel_sampled(const PointView& cloud, double cell) {
  if (!(cell > 0) || !std::isfinite(cell)) {
    throw BadInput(fmt::format("cannot sample a cloud to cells of {} m", cell));
  }
  check_cloud(cloud);
  std::size_t count = 0;
  const auto cells = cells_of(cloud, cell, count);
  PointCloud result;
  result.points.assign(count, Eigen::Vector3d::Zero());
  if (cloud.has_normals()) result.normals.assign(count, Eigen::Vector3d::Zero());
  std::vector<double> members(count, 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::size_t k = cells[i];
    members[k] += 1;
    result.points[k] += (cloud.point(i) - result.points[k]) / members[k];
    if (!cloud.has_normals()) continue;
    // The two sides of a thin sheet may cancel: the first normal then stands.
    const Eigen::Vector3d sum = result.normals[k] + cloud.normal(i);
    if (sum.norm() > 1e-6) result.normals[k] = sum;
  }
  for (auto& n : result.normals) n.normalize();
  return result;
}

double voxel_cell_for(const PointView& cloud, std::size_t most) {
  constexpr std::size_t kMembers = 4;  // of a cell, on average: of fewer some stay empty
  if (cloud.size() <= most || most == 0) return 0;
  const Eigen::AlignedBox3d box = box_of(cloud);
  const double finest = box.diagonal().norm() / 1000;
  if (!(finest > 0)) return 0;
  // Some of the points leave cells empty, so that theirs is too fine rather than too coarse.
  const std::size_t stride = cloud.size() / (kMembers * most);
  const double rough = stride > 1 ? cell_from(cloud, stride, box.min(), most, finest) : finest;
  return cell_from(cloud, 1, box.min(), most, rough);
}

}  // namespace palpate::geometry
