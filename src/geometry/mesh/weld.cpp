// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/weld.hpp"

#include <algorithm>
#include <numeric>

namespace palpate::geometry {

std::vector<int> first_at_same_position(const TriangleMesh& mesh) {
  const auto at = [&mesh](int i) -> const Eigen::Vector3d& {
    return mesh.vertices[static_cast<std::size_t>(i)];
  };
  std::vector<int> order(mesh.vertices.size()), first(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&at](int i, int j) {
    const auto &a = at(i), &b = at(j);
    for (int axis = 0; axis < 3; ++axis) {
      if (a[axis] != b[axis]) return a[axis] < b[axis];
    }
    return i < j;
  });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && at(order[k]) == at(order[k - 1]);
    first[static_cast<std::size_t>(order[k])] =
        same ? first[static_cast<std::size_t>(order[k - 1])] : order[k];
  }
  return first;
}

TriangleMesh merged(const TriangleMesh& mesh, const std::vector<int>& target) {
  std::vector<int> place(mesh.vertices.size(), -1);
  TriangleMesh result;
  for (auto triangle : mesh.triangles) {
    for (int& corner : triangle) {
      const auto kept = static_cast<std::size_t>(target[static_cast<std::size_t>(corner)]);
      if (place[kept] < 0) {
        place[kept] = static_cast<int>(result.vertices.size());
        result.vertices.push_back(mesh.vertices[kept]);
      }
      corner = place[kept];
    }
    result.triangles.push_back(triangle);
  }
  return result;
}

}  // namespace palpate::geometry
