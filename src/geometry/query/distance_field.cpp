// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/query/distance_field.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <string>

#include "palpate/core/cache.hpp"
#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

constexpr double kMaxNodes = 1e8;        // 1.6 GB
constexpr double kNearSurface = 0.0002;  // m; nearer, the direction to the surface is ill-defined

/// Distances of a sequence of points, each found the faster the nearer it is to the one before.
class Walker {
 public:
  explicit Walker(const MeshQuery& mesh) : mesh_(mesh) {}

  /// Outward direction and signed distance at p.
  Eigen::Vector4f step_to(const Eigen::Vector3d& p) {
    const ClosestPoint closest = mesh_.closest_point(p, last_.triangle);
    // A step shorter than the distance to the surface cannot cross it, so the side stays the same.
    const double free = std::max(closest.distance, last_.distance);
    const bool same_side = last_.triangle >= 0 && free > 1.001 * (p - point_).norm();
    if (!same_side) inside_ = mesh_.inside(p);
    last_ = closest;
    point_ = p;
    const double distance = inside_ ? -closest.distance : closest.distance;
    Eigen::Vector3d outward = closest.normal;
    if (closest.distance >= kNearSurface) outward = (p - closest.point) / distance;
    Eigen::Vector4f node;
    node << outward.cast<float>(), static_cast<float>(distance);
    return node;
  }

 private:
  const MeshQuery& mesh_;
  ClosestPoint last_;
  Eigen::Vector3d point_ = Eigen::Vector3d::Zero();
  bool inside_ = false;
};

Eigen::Array3i grid_size(const Eigen::Vector3d& extent, double cell) {
  const Eigen::Array3d size = (extent.array() / cell).ceil() + 1;
  if (!(size.prod() <= kMaxNodes)) {
    throw BadInput(fmt::format("distance field of {:.3g} x {:.3g} x {:.3g} nodes exceeds {:.3g}",
                               size[0], size[1], size[2], kMaxNodes));
  }
  return size.max(2).cast<int>();
}

template <class Value>
void append(std::string& bytes, const Value* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(Value));
}

/// All that the nodes depend on.
std::string cache_key(const TriangleMesh& mesh, double cell, double padding) {
  std::string key = fmt::format("distance field 1: cell {}, padding {}, {} vertices\n", cell,
                                padding, mesh.vertices.size());
  for (const auto& vertex : mesh.vertices) append(key, vertex.data(), 3);
  for (const auto& triangle : mesh.triangles) append(key, triangle.data(), 3);
  return key;
}

}  // namespace

DistanceField::DistanceField(const MeshQuery& mesh, double cell, double padding)
    : cell_(static_cast<float>(cell)), beyond_(static_cast<float>(padding)) {
  if (!(cell > 0 && padding >= 0)) {
    throw BadInput(fmt::format("distance field: cell {} m, padding {} m", cell, padding));
  }
  const Eigen::AlignedBox3d box = bounds(mesh.mesh());
  origin_ = (box.min().array() - padding).cast<float>();
  size_ = grid_size(box.sizes().array() + 2 * padding, cell_);
  const std::string key = cache_key(mesh.mesh(), cell, padding);
  if (const auto kept = read_cache(key); kept && take_nodes(*kept)) return;
  fill(mesh);
  std::string bytes;
  append(bytes, nodes_.data(), nodes_.size());
  write_cache(key, bytes);
}

bool DistanceField::take_nodes(std::string_view bytes) {
  const auto count = static_cast<std::size_t>(size_.cast<double>().prod());
  if (bytes.size() != count * sizeof(Eigen::Vector4f)) return false;
  nodes_.resize(count);
  std::memcpy(nodes_.data()->data(), bytes.data(), bytes.size());
  return true;
}

void DistanceField::fill(const MeshQuery& mesh) {
  nodes_.reserve(static_cast<std::size_t>(size_.cast<double>().prod()));
  Walker walker(mesh);
  for (int x = 0; x < size_[0]; ++x) {
    for (int y = 0; y < size_[1]; ++y) {
      for (int z = 0; z < size_[2]; ++z) {
        const Eigen::Vector3f node = origin_ + cell_ * Eigen::Vector3i(x, y, z).cast<float>();
        nodes_.push_back(walker.step_to(node.cast<double>()));
      }
    }
  }
}

std::optional<DistanceField::Cell> DistanceField::cell_of(const Eigen::Vector3f& p) const {
  const Eigen::Array3f at = (p - origin_).array() / cell_;
  if (!((at >= 0).all() && (at <= (size_ - 1).cast<float>()).all())) return std::nullopt;
  return cell_at(at);
}

/// @param at  a place in the grid, in cells
DistanceField::Cell DistanceField::cell_at(const Eigen::Array3f& at) const {
  const Eigen::Array3i low = at.cast<int>().min(size_ - 2);
  const auto row = static_cast<std::size_t>(size_[2]);
  const std::size_t slab = row * static_cast<std::size_t>(size_[1]);
  return Cell{&nodes_[static_cast<std::size_t>(low[0]) * slab +
                      static_cast<std::size_t>(low[1]) * row + static_cast<std::size_t>(low[2])],
              at - low.cast<float>()};
}

/// Linear between two nodes along an axis, the distance less what a curve lies below its chord.
Eigen::Vector4f DistanceField::blend(const Eigen::Vector4f& low, const Eigen::Vector4f& high,
                                     int axis, float t) const {
  const Eigen::Vector4f change = high - low;
  Eigen::Vector4f value = low + t * change;
  value[3] -= 0.5F * cell_ * t * (1 - t) * change[axis];
  return value;
}

std::optional<DistanceField::Sample> DistanceField::at(const Eigen::Vector3f& p) const {
  const auto cell = cell_of(p);
  return cell ? std::optional(sample_in(*cell)) : std::nullopt;
}

DistanceField::Sample DistanceField::anywhere(const Eigen::Vector3f& p) const {
  if (const auto cell = cell_of(p)) return sample_in(*cell);
  const Eigen::Array3f at = ((p - origin_).array() / cell_).max(0).min((size_ - 1).cast<float>());
  const Eigen::Vector3f way = p - origin_ - cell_ * at.matrix();
  Sample sample = sample_in(cell_at(at));
  sample.distance += way.norm();
  for (int axis = 0; axis < 3; ++axis) {  // along the others the nearest point of the grid moves
    if (way[axis] != 0) sample.gradient[axis] = way[axis] / way.norm();
  }
  return sample;
}

DistanceField::Sample DistanceField::sample_in(const Cell& cell) const {
  const auto& [node, t] = cell;
  const auto row = static_cast<std::size_t>(size_[2]);
  const std::size_t slab = row * static_cast<std::size_t>(size_[1]);
  const auto along_z = [&](const Eigen::Vector4f* n) { return blend(n[0], n[1], 2, t[2]); };
  const Eigen::Vector4f n00 = along_z(node), n01 = along_z(node + row);
  const Eigen::Vector4f n10 = along_z(node + slab), n11 = along_z(node + slab + row);
  const Eigen::Vector4f n0 = blend(n00, n01, 1, t[1]), n1 = blend(n10, n11, 1, t[1]);
  const Eigen::Vector4f value = blend(n0, n1, 0, t[0]);
  const auto across_z = [&](const Eigen::Vector4f* n) -> Eigen::Vector4f { return n[1] - n[0]; };
  const Eigen::Vector4f z0 = (1 - t[1]) * across_z(node) + t[1] * across_z(node + row);
  const Eigen::Vector4f z1 =
      (1 - t[1]) * across_z(node + slab) + t[1] * across_z(node + slab + row);
  const Eigen::Vector3f by_x = (n1 - n0).head<3>();  // change of the gradient over a cell
  const Eigen::Vector3f by_y = ((1 - t[0]) * (n01 - n00) + t[0] * (n11 - n10)).head<3>();
  const Eigen::Vector3f by_z = ((1 - t[0]) * z0 + t[0] * z1).head<3>();
  const float changes = by_x.squaredNorm() + by_y.squaredNorm() + by_z.squaredNorm();
  return Sample{value[3], value.head<3>(), 0.5F * changes / (cell_ * cell_)};
}

float DistanceField::distance(const Eigen::Vector3f& p) const {
  const auto cell = cell_of(p);
  if (!cell) return beyond_;
  const auto& [node, t] = *cell;
  const auto row = static_cast<std::size_t>(size_[2]);
  const std::size_t slab = row * static_cast<std::size_t>(size_[1]);
  const auto along_z = [&](const Eigen::Vector4f* n) { return blend(n[0], n[1], 2, t[2]); };
  const Eigen::Vector4f n0 = blend(along_z(node), along_z(node + row), 1, t[1]);
  const Eigen::Vector4f n1 = blend(along_z(node + slab), along_z(node + slab + row), 1, t[1]);
  return blend(n0, n1, 0, t[0])[3];
}

}  // namespace palpate::geometry
