// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/polygon.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace palpate::geometry {
namespace {

struct Corner {
  Eigen::Vector2d at;
  int vertex;
};

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// The loop seen from the side to which it winds counter-clockwise.
std::vector<Corner> flattened(const std::vector<Eigen::Vector3d>& vertices,
                              std::span<const int> loop) {
  const auto at = [&](std::size_t k) -> const Eigen::Vector3d& {
    return vertices[static_cast<std::size_t>(loop[k % loop.size()])];
  };
  Eigen::Vector3d area = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < loop.size(); ++k) {
    area += (at(k) - at(0)).cross(at(k + 1) - at(0));
  }
  const Eigen::Vector3d x = area.unitOrthogonal(), y = area.normalized().cross(x);
  std::vector<Corner> corners;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Eigen::Vector3d p = at(k) - at(0);
    corners.push_back({{x.dot(p), y.dot(p)}, loop[k]});
  }
  return corners;
}

bool is_ear(const std::vector<Corner>& corners, std::size_t k,
            const std::function<bool(int, int)>& may_cut) {
  const std::size_t n = corners.size();
  const Corner &a = corners[(k + n - 1) % n], &b = corners[k], &c = corners[(k + 1) % n];
  if (!(cross(b.at - a.at, c.at - b.at) > 0)) return false;
  if (may_cut && !may_cut(a.vertex, c.vertex)) return false;
  return std::none_of(corners.begin(), corners.end(), [&](const Corner& other) {
    if (other.vertex == a.vertex || other.vertex == b.vertex || other.vertex == c.vertex) {
      return false;
    }
    return cross(b.at - a.at, other.at - a.at) >= 0 && cross(c.at - b.at, other.at - b.at) >= 0 &&
           cross(a.at - c.at, other.at - c.at) >= 0;
  });
}

/// Index of the ear with the shortest cut, or the number of corners if there is none.
std::size_t best_ear(const std::vector<Corner>& corners,
                     const std::function<bool(int, int)>& may_cut) {
  const std::size_t n = corners.size();
  std::vector<std::pair<double, std::size_t>> cuts;
  for (std::size_t k = 0; k < n; ++k) {
    const double cut = (corners[(k + 1) % n].at - corners[(k + n - 1) % n].at).squaredNorm();
    cuts.emplace_back(cut, k);
  }
  std::sort(cuts.begin(), cuts.end());
  for (const auto& [cut, k] : cuts) {
    if (is_ear(corners, k, may_cut)) return k;
  }
  return n;
}

}  // namespace

std::optional<std::vector<std::array<int, 3>>> clip_ears(
    const std::vector<Eigen::Vector3d>& vertices, std::span<const int> loop,
    const std::function<bool(int, int)>& may_cut) {
  std::vector<std::array<int, 3>> triangles;
  std::vector<Corner> corners = flattened(vertices, loop);
  while (corners.size() > 3) {
    const std::size_t n = corners.size(), k = best_ear(corners, may_cut);
    if (k == n) return std::nullopt;
    triangles.push_back(
        {corners[(k + n - 1) % n].vertex, corners[k].vertex, corners[(k + 1) % n].vertex});
    corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(k));
  }
  triangles.push_back({corners[0].vertex, corners[1].vertex, corners[2].vertex});
  return triangles;
}

}  // namespace palpate::geometry
