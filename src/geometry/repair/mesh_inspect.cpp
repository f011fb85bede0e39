// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>
#include <set>

#include "geometry/mesh/mesh_topology.hpp"
#include "geometry/mesh/triangle.hpp"
#include "palpate/geometry/repair/mesh_repair.hpp"

namespace palpate::geometry {
namespace {

void count_faces(const TriangleMesh& mesh, MeshReport& report) {
  std::set<std::array<int, 3>> seen;
  for (auto triangle : mesh.triangles) {
    report.degenerate_faces += is_degenerate(corners(mesh, triangle)) ? 1 : 0;
    std::sort(triangle.begin(), triangle.end());
    report.duplicate_faces += seen.insert(triangle).second ? 0 : 1;
  }
}

void count_edges(const TriangleMesh& mesh, MeshReport& report) {
  for_each_edge(edge_uses(mesh), [&report](std::span<const EdgeUse> edge) {
    if (edge.size() == 1) ++report.boundary_edges;
    if (edge.size() > 2) ++report.non_manifold_edges;
    if (edge.size() == 2 && edge[0].forward == edge[1].forward) ++report.flipped_edges;
  });
}

}  // namespace

MeshReport inspect(const TriangleMesh& mesh) {
  check_mesh(mesh);
  MeshReport report;
  report.vertices = static_cast<int>(mesh.vertices.size());
  report.triangles = static_cast<int>(mesh.triangles.size());
  const std::vector<int> labels = component_labels(mesh);
  for (const int label : labels) report.components = std::max(report.components, label + 1);
  count_faces(mesh, report);
  count_edges(mesh, report);
  report.watertight = report.triangles > 0 && report.boundary_edges == 0 &&
                      report.non_manifold_edges == 0 && report.flipped_edges == 0;
  report.volume = signed_volume(mesh);
  return report;
}

std::vector<TriangleMesh> components(const TriangleMesh& mesh) {
  const std::vector<int> labels = component_labels(mesh);
  const int count = labels.empty() ? 0 : *std::max_element(labels.begin(), labels.end()) + 1;
  std::vector<TriangleMesh> parts(static_cast<std::size_t>(count));
  std::vector<int> part_of(mesh.vertices.size(), -1), place(mesh.vertices.size());
  std::vector<std::size_t> order(labels.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&labels](std::size_t a, std::size_t b) { return labels[a] < labels[b]; });
  for (const std::size_t i : order) {
    TriangleMesh& part = parts[static_cast<std::size_t>(labels[i])];
    auto triangle = mesh.triangles[i];
    for (int& corner : triangle) {
      const auto vertex = static_cast<std::size_t>(corner);
      if (part_of[vertex] != labels[i]) {
        part_of[vertex] = labels[i];
        place[vertex] = static_cast<int>(part.vertices.size());
        part.vertices.push_back(mesh.vertices[vertex]);
      }
      corner = place[vertex];
    }
    part.triangles.push_back(triangle);
  }
  return parts;
}

}  // namespace palpate::geometry
