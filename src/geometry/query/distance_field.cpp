// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/query/distance_field.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <string>

#include "core/lanes.hpp"
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

using Node = Floats4;  // gradient and distance

Node load(const Eigen::Vector4f& stored) {
  Node node;
  std::memcpy(&node, stored.data(), sizeof(node));
  return node;
}

/// Two nodes, or two values between nodes, that lie side by side along an axis.
struct Pair {
  Node low, change;
};

Pair pair_of(Node low, Node high) { return {low, high - low}; }

/// Where a point lies between the two ends of a cell along an axis, and how far the chord of a
/// curve of unit change of slope lies above it there.
struct Between {
  float t, sag;
};

/// Linear along an axis, the distance less what a curve lies below its chord.
template <int kAxis>
Node blend(const Pair& pair, const Between& between) {
  constexpr Ints4 kDistance{0, 0, 0, -1};
  const Node bend = __builtin_shufflevector(pair.change, pair.change, kAxis, kAxis, kAxis, kAxis);
  const auto sag = Node(Ints4(between.sag * bend) & kDistance);
  return pair.low + between.t * pair.change - sag;
}

/// Of the components of the gradient.
float squared_norm(Node change) {
  return Eigen::Vector3f(change[0], change[1], change[2]).squaredNorm();
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

/// @param at  a place in the grid, in cells
inline DistanceField::Cell DistanceField::cell_at(const Eigen::Array3f& at) const {
  const Eigen::Array3i low = at.cast<int>().min(size_ - 2);
  const auto row = static_cast<std::size_t>(size_[2]);
  const std::size_t slab = row * static_cast<std::size_t>(size_[1]);
  return Cell{&nodes_[static_cast<std::size_t>(low[0]) * slab +
                      static_cast<std::size_t>(low[1]) * row + static_cast<std::size_t>(low[2])],
              at - low.cast<float>()};
}

inline std::optional<DistanceField::Cell> DistanceField::cell_of(const Eigen::Vector3f& p) const {
  const Eigen::Array3f at = (p - origin_).array() / cell_;
  if (!((at >= 0).all() && (at <= (size_ - 1).cast<float>()).all())) return std::nullopt;
  return cell_at(at);
}

DistanceField::Cell DistanceField::fetched(const Eigen::Vector3f& p) const {
  const auto cell = cell_of(p);
  if (!cell) return {nullptr, {}};
  const auto row = static_cast<std::size_t>(size_[2]);
  const std::size_t slab = row * static_cast<std::size_t>(size_[1]);
  for (const std::size_t of_cell : {std::size_t{0}, row, slab, slab + row}) {
    __builtin_prefetch(cell->node + of_cell);
    __builtin_prefetch(cell->node + of_cell + 1);  // they may lie in two lines of the cache
  }
  return *cell;
}

std::optional<DistanceField::Sample> DistanceField::at(const Eigen::Vector3f& p) const {
  const auto cell = cell_of(p);
  return cell ? std::optional(at(*cell)) : std::nullopt;
}

DistanceField::Sample DistanceField::anywhere(const Eigen::Vector3f& p) const {
  if (const auto cell = cell_of(p)) return at(*cell);
  const Eigen::Array3f nearest =
      ((p - origin_).array() / cell_).max(0).min((size_ - 1).cast<float>());
  const Eigen::Vector3f way = p - origin_ - cell_ * nearest.matrix();
  Sample sample = at(cell_at(nearest));
  sample.distance += way.norm();
  for (int axis = 0; axis < 3; ++axis) {  // along the others the nearest point of the grid moves
    if (way[axis] != 0) sample.gradient[axis] = way[axis] / way.norm();
  }
  return sample;
}

/// The nodes of a cell by pairs along z, and where the point lies along each axis.
struct DistanceField::Corners {
  Pair z00, z01, z10, z11;
  Between x, y, z;
};

inline DistanceField::Corners DistanceField::corners_of(const Cell& cell) const {
  const auto& [node, t] = cell;
  const auto row = static_cast<std::size_t>(size_[2]);
  const std::size_t slab = row * static_cast<std::size_t>(size_[1]);
  const auto along_z = [](const Eigen::Vector4f* n) { return pair_of(load(n[0]), load(n[1])); };
  const auto between = [&](int axis) {
    return Between{t[axis], 0.5F * cell_ * t[axis] * (1 - t[axis])};
  };
  return {along_z(node),
          along_z(node + row),
          along_z(node + slab),
          along_z(node + slab + row),
          between(0),
          between(1),
          between(2)};
}

DistanceField::Sample DistanceField::at(const Cell& cell) const {
  const Corners at = corners_of(cell);
  const Pair y0 = pair_of(blend<2>(at.z00, at.z), blend<2>(at.z01, at.z));
  const Pair y1 = pair_of(blend<2>(at.z10, at.z), blend<2>(at.z11, at.z));
  const Pair x = pair_of(blend<1>(y0, at.y), blend<1>(y1, at.y));
  const Node value = blend<0>(x, at.x);
  const Node z0 = (1 - at.y.t) * at.z00.change + at.y.t * at.z01.change;
  const Node z1 = (1 - at.y.t) * at.z10.change + at.y.t * at.z11.change;
  const Node by_y = (1 - at.x.t) * y0.change + at.x.t * y1.change;  // of the gradient, over a cell
  const Node by_z = (1 - at.x.t) * z0 + at.x.t * z1;
  const float changes = squared_norm(x.change) + squared_norm(by_y) + squared_norm(by_z);
  return Sample{value[3], {value[0], value[1], value[2]}, 0.5F * changes / (cell_ * cell_)};
}

float DistanceField::distance(const Cell& cell) const {
  const Corners at = corners_of(cell);
  const Pair y0 = pair_of(blend<2>(at.z00, at.z), blend<2>(at.z01, at.z));
  const Pair y1 = pair_of(blend<2>(at.z10, at.z), blend<2>(at.z11, at.z));
  return blend<0>(pair_of(blend<1>(y0, at.y), blend<1>(y1, at.y)), at.x)[3];
}

float DistanceField::distance(const Eigen::Vector3f& p) const {
  const auto cell = cell_of(p);
  return cell ? distance(*cell) : beyond_;
}

}  // namespace palpate::geometry
