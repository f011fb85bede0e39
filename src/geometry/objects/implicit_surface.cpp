// SPDX-License-Identifier: Apache-2.0
#include "geometry/objects/implicit_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

using Index = std::int64_t;

/// A vertex keeps this share of its edge away from the edge's ends, so that no triangle is flat.
constexpr double kMinShare = 0.02;

/// The six tetrahedra of a cube about its diagonal from corner 0 to corner 7 (bits: x, y, z), of
/// positive volume. Neighbouring cubes split their common face alike.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra = {
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

class Marcher {
 public:
  Marcher(const Solid& solid, const Eigen::AlignedBox3d& box, double cell)
      : origin_(box.min()), cell_(cell) {
    for (int k = 0; k < 3; ++k) {
      nodes_[k] = 2 + static_cast<Index>(std::ceil(box.sizes()[k] / cell));
    }
    sample(solid);
  }

  TriangleMesh march() {
    for (Index x = 0; x + 1 < nodes_[0]; ++x) {
      for (Index y = 0; y + 1 < nodes_[1]; ++y) {
        for (Index z = 0; z + 1 < nodes_[2]; ++z) march_cube(number(x, y, z));
      }
    }
    return std::move(mesh_);
  }

 private:
  Index number(Index x, Index y, Index z) const { return (x * nodes_[1] + y) * nodes_[2] + z; }

  Eigen::Vector3d position(Index node) const {
    const Index z = node % nodes_[2], y = node / nodes_[2] % nodes_[1],
                x = node / (nodes_[1] * nodes_[2]);
    return origin_ + cell_ * Eigen::Vector3d(static_cast<double>(x), static_cast<double>(y),
                                             static_cast<double>(z));
  }

  double value(Index node) const { return values_[static_cast<std::size_t>(node)]; }

  void sample(const Solid& solid) {
    values_.reserve(static_cast<std::size_t>(nodes_[0] * nodes_[1] * nodes_[2]));
    for (Index x = 0; x < nodes_[0]; ++x) {
      for (Index y = 0; y < nodes_[1]; ++y) {
        for (Index z = 0; z < nodes_[2]; ++z) {
          const bool border = x == 0 || y == 0 || z == 0 || x + 1 == nodes_[0] ||
                              y + 1 == nodes_[1] || z + 1 == nodes_[2];
          const double distance = solid(position(number(x, y, z)));
          values_.push_back(border ? std::max(distance, 0.1 * cell_) : distance);
        }
      }
    }
  }

  void march_cube(Index corner) {
    std::array<Index, 8> corners{};
    int inside = 0;
    for (std::size_t c = 0; c < 8; ++c) {
      const auto bit = [&](std::size_t k) { return static_cast<Index>(c >> k & 1); };
      corners[c] = corner + (bit(0) * nodes_[1] + bit(1)) * nodes_[2] + bit(2);
      inside += value(corners[c]) < 0;
    }
    if (inside == 0 || inside == 8) return;
    for (const auto& tetrahedron : kTetrahedra) {
      std::array<Index, 4> nodes{};
      for (std::size_t k = 0; k < 4; ++k) {
        nodes[k] = corners[static_cast<std::size_t>(tetrahedron[k])];
      }
      march_tetrahedron(nodes);
    }
  }

  /// Sorts the nodes inside to the front; an odd permutation mirrors the tetrahedron.
  void march_tetrahedron(std::array<Index, 4> t) {
    bool odd = false;
    std::size_t inside = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (value(t[k]) >= 0) continue;
      odd ^= k != inside;
      std::swap(t[k], t[inside++]);
    }
    if (inside == 0 || inside == 4) return;
    if (inside == 1) {
      add(edge(t[0], t[1]), edge(t[0], t[2]), edge(t[0], t[3]), odd);
    } else if (inside == 3) {
      add(edge(t[3], t[0]), edge(t[3], t[1]), edge(t[3], t[2]), odd);
    } else {
      const int a = edge(t[0], t[2]), b = edge(t[0], t[3]), c = edge(t[1], t[3]),
                d = edge(t[1], t[2]);
      add(a, b, c, odd);
      add(a, c, d, odd);
    }
  }

  void add(int a, int b, int c, bool flipped) {
    if (flipped) std::swap(b, c);
    mesh_.triangles.push_back({a, b, c});
  }

  /// The vertex where the surface crosses the edge between two nodes.
  int edge(Index a, Index b) {
    if (a > b) std::swap(a, b);
    const Index key = a * static_cast<Index>(values_.size()) + b;
    const auto [found, is_new] = vertices_.emplace(key, static_cast<int>(mesh_.vertices.size()));
    if (is_new) {
      const double share = std::clamp(value(a) / (value(a) - value(b)), kMinShare, 1 - kMinShare);
      mesh_.vertices.emplace_back((1 - share) * position(a) + share * position(b));
    }
    return found->second;
  }

  Eigen::Vector3d origin_;
  double cell_;
  std::array<Index, 3> nodes_{};
  std::vector<double> values_;
  std::unordered_map<Index, int> vertices_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh extract_surface(const Solid& solid, const Eigen::AlignedBox3d& box, double cell) {
  if (!(cell > 0 && std::isfinite(cell)) || !box.sizes().allFinite() ||
      !(box.sizes().minCoeff() > 0)) {
    throw BadInput(fmt::format("a surface needs a positive cell and box, not {} m and {} x {} x {}",
                               cell, box.sizes().x(), box.sizes().y(), box.sizes().z()));
  }
  return Marcher(solid, box, cell).march();
}

}  // namespace palpate::geometry
