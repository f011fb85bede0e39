// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/mesh/sampling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "geometry/mesh/mesh_topology.hpp"
#include "geometry/mesh/triangle.hpp"
#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

/// Uniform over the triangle (Turk 1990).
Eigen::Vector3d point_within(const Corners& t, RandomStream& random) {
  const double s = std::sqrt(random.uniform()), r = random.uniform();
  return (1 - s) * t[0] + s * (1 - r) * t[1] + s * r * t[2];
}

/// For each triangle the area up to and with it.
std::vector<double> cumulated_areas(const TriangleMesh& mesh) {
  std::vector<double> areas;
  double sum = 0;
  for (const auto& triangle : mesh.triangles) {
    sum += area_normal(corners(mesh, triangle)).norm() / 2;
    areas.push_back(sum);
  }
  return areas;
}

/// For each vertex the number of its cell, among those that hold vertices.
std::vector<std::size_t> occupied_cells(const TriangleMesh& mesh, double cell) {
  std::map<std::array<double, 3>, std::size_t> number;
  std::vector<std::size_t> cells;
  for (const auto& vertex : mesh.vertices) {
    const Eigen::Vector3d at = (vertex / cell).array().floor();
    cells.push_back(number.try_emplace({at.x(), at.y(), at.z()}, number.size()).first->second);
  }
  return cells;
}

}  // namespace

std::vector<SurfaceSample> sample_surface(const TriangleMesh& mesh, std::size_t count,
                                          RandomStream random) {
  check_mesh(mesh);
  const std::vector<double> areas = cumulated_areas(mesh);
  if (areas.empty() || !(areas.back() > 0))
    throw BadInput("no surface to sample: the mesh has no area");
  std::vector<SurfaceSample> samples;
  samples.reserve(count);
  const double stratum = areas.back() / static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double at = (static_cast<double>(i) + random.uniform()) * stratum;
    // Strictly above, so that a triangle without area is never chosen.
    auto found = std::upper_bound(areas.begin(), areas.end(), at);
    if (found == areas.end()) found = std::lower_bound(areas.begin(), areas.end(), areas.back());
    const auto triangle = static_cast<std::size_t>(found - areas.begin());
    const Corners t = corners(mesh, mesh.triangles[triangle]);
    samples.push_back({point_within(t, random), area_normal(t).normalized()});
  }
  return samples;
}

TriangleMesh simplified(const TriangleMesh& mesh, double cell) {
  if (!(cell > 0)) throw BadInput(fmt::format("cannot simplify to cells of {} m", cell));
  check_mesh(mesh);
  const std::vector<std::size_t> cells = occupied_cells(mesh, cell);
  const std::size_t count = cells.empty() ? 0 : *std::max_element(cells.begin(), cells.end()) + 1;
  TriangleMesh result;
  result.vertices.assign(count, Eigen::Vector3d::Zero());
  std::vector<double> members(count, 0);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    members[cells[i]] += 1;
    Eigen::Vector3d& mean = result.vertices[cells[i]];
    mean += (mesh.vertices[i] - mean) / members[cells[i]];
  }
  std::set<std::array<int, 3>> seen;
  for (auto triangle : mesh.triangles) {
    for (int& corner : triangle) {
      corner = static_cast<int>(cells[static_cast<std::size_t>(corner)]);
    }
    const auto& [a, b, c] = triangle;
    if (a == b || b == c || c == a) continue;
    auto smallest_first = triangle;  // keeps the winding: a sheet of two sides stays two-sided
    std::rotate(smallest_first.begin(),
                std::min_element(smallest_first.begin(), smallest_first.end()),
                smallest_first.end());
    if (seen.insert(smallest_first).second) result.triangles.push_back(triangle);
  }
  return result;
}

}  // namespace palpate::geometry
