// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <set>

#include "geometry/mesh/loft.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/geometry/objects/shapes.hpp"

// The mug is a lathed cup whose outer wall has two oval holes; a tube, the handle, is stitched to
// their edges, vertex to vertex, so that the surface is one manifold without internal faces.
namespace palpate::geometry {
namespace {

constexpr double kRadius = 0.046, kHeight = 0.081, kWall = 0.004;
constexpr double kHandleOut = 0.025, kHandleHeight = 0.055;
constexpr double kTubeHalfWidth = 0.0065, kTubeHalfThickness = 0.004;
constexpr int kColumns = 72;
constexpr int kHalfHole = 2;            // grid cells from a hole's centre to its edge
constexpr int kAround = 8 * kHalfHole;  // vertices around a hole and around the tube

constexpr double kRow = kTubeHalfThickness / kHalfHole;  // spacing of the grid's rows at a hole
constexpr double kPathHalfHeight = kHandleHeight / 2 - kTubeHalfThickness;
constexpr double kLowHole = kHeight / 2 - kPathHalfHeight;
constexpr double kHighHole = kHeight / 2 + kPathHalfHeight;

struct Cup {
  std::vector<Ring> rings;
  std::array<int, 2> hole_rings;  // the ring at the centre of the lower and the upper hole
};

Cup cup() {
  Cup cup{};
  const auto add = [&](double radius, double z) {
    cup.rings.push_back(ellipse(radius, radius, z, kColumns));
  };
  const double edge = kWall / 2, inner = kRadius - kWall;
  add(kRadius - edge, 0);
  add(kRadius - 0.3 * edge, 0.3 * edge);
  add(kRadius, edge);
  add(kRadius, kLowHole - 2 * kTubeHalfThickness);
  for (int hole : {0, 1}) {
    const double centre = hole ? kHighHole : kLowHole;
    for (int i = -kHalfHole; i <= kHalfHole; ++i) {
      if (i == 0)
        cup.hole_rings[static_cast<std::size_t>(hole)] = static_cast<int>(cup.rings.size());
      add(kRadius, centre + i * kRow);
    }
    if (hole == 0) {
      for (double share : {0.25, 0.5, 0.75})
        add(kRadius, kLowHole + share * (kHighHole - kLowHole));
    }
  }
  constexpr int kRimSteps = 6;
  for (int i = 0; i <= kRimSteps; ++i) {  // a half circle over the wall
    const double angle = kPi * i / kRimSteps;
    add(kRadius - edge + edge * std::cos(angle), kHeight - edge + edge * std::sin(angle));
  }
  for (double share : {0.67, 0.33}) add(inner, kWall + share * (kHeight - kWall));
  add(inner, kWall + edge);
  add(inner - 0.3 * edge, kWall + 0.3 * edge);
  add(inner - edge, kWall);
  return cup;
}

struct GridCell {
  int row, column;  // from the hole's centre
};

/// The i-th grid vertex on a hole's edge, from +y (seen from outside: the right) through +z.
GridCell hole_edge(int i) {
  const int side = ((i + kHalfHole) % kAround) / (2 * kHalfHole);
  const int along = (i + kHalfHole) % (2 * kHalfHole) - kHalfHole;
  switch (side) {
    case 0:
      return {along, kHalfHole};
    case 1:
      return {kHalfHole, -along};
    case 2:
      return {-along, -kHalfHole};
    default:
      return {-kHalfHole, along};
  }
}

int grid_vertex(int centre_ring, GridCell cell) {
  return 1 + (centre_ring + cell.row) * kColumns + (cell.column + kColumns) % kColumns;
}

/// Moves a hole's edge onto the oval in which the handle's tube meets the wall; the edge's
/// vertices.
std::vector<int> shape_hole(TriangleMesh& mesh, int centre_ring, double centre_z) {
  std::vector<int> edge;
  for (int i = 0; i < kAround; ++i) {
    const double angle = 2 * kPi * i / kAround;
    const double y = kTubeHalfWidth * std::cos(angle);
    edge.push_back(grid_vertex(centre_ring, hole_edge(i)));
    mesh.vertices[static_cast<std::size_t>(edge.back())] = {
        std::sqrt(kRadius * kRadius - y * y), y, centre_z + kTubeHalfThickness * std::sin(angle)};
  }
  return edge;
}

/// Removes the triangles inside the holes and the vertices that only they used.
void cut_holes(TriangleMesh& mesh, const std::array<int, 2>& hole_rings) {
  std::set<int> inside;
  for (int ring : hole_rings) {
    for (int row = 1 - kHalfHole; row < kHalfHole; ++row) {
      for (int c = 1 - kHalfHole; c < kHalfHole; ++c) inside.insert(grid_vertex(ring, {row, c}));
    }
  }
  // By the square rather than by inner vertices: a corner cell may have a triangle without any.
  const auto in_hole = [&](const std::array<int, 3>& triangle) {
    for (int ring : hole_rings) {
      bool all = true;
      for (int v : triangle) {
        const int row = (v - 1) / kColumns - ring, column = (v - 1) % kColumns;
        const int offset = column > kColumns / 2 ? column - kColumns : column;
        all = all && v > 0 && std::abs(row) <= kHalfHole && std::abs(offset) <= kHalfHole;
      }
      if (all) return true;
    }
    return false;
  };
  std::erase_if(mesh.triangles, in_hole);

  std::vector<int> new_index(mesh.vertices.size());
  std::vector<Eigen::Vector3d> kept;
  for (int v = 0; v < static_cast<int>(mesh.vertices.size()); ++v) {
    new_index[static_cast<std::size_t>(v)] = static_cast<int>(kept.size());
    if (!inside.contains(v)) kept.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
  }
  mesh.vertices = std::move(kept);
  for (auto& triangle : mesh.triangles) {
    for (int& v : triangle) v = new_index[static_cast<std::size_t>(v)];
  }
}

/// Cross-section of the tube at `share` of its way, 0..1, from the upper to the lower hole. The
/// path is half a superellipse of exponent 5/2, which leaves the wall at a right angle.
Ring tube_section(double share) {
  constexpr double kExponent = 2.5, kOut = kHandleOut - kTubeHalfThickness;
  const double angle = kPi * share;
  const double u = std::pow(std::sin(angle), 2 / kExponent);
  const double v =
      std::copysign(std::pow(std::abs(std::cos(angle)), 2 / kExponent), std::cos(angle));
  const Eigen::Vector3d centre(kRadius + kOut * u, 0, kHeight / 2 + kPathHalfHeight * v);
  const Eigen::Vector3d outward =
      Eigen::Vector3d(std::pow(u, kExponent - 1) / kOut, 0,
                      std::copysign(std::pow(std::abs(v), kExponent - 1), v) / kPathHalfHeight)
          .normalized();
  Ring ring;
  for (int i = 0; i < kAround; ++i) {
    const double around = 2 * kPi * i / kAround;
    ring.push_back(centre + kTubeHalfWidth * std::cos(around) * Eigen::Vector3d::UnitY() +
                   kTubeHalfThickness * std::sin(around) * outward);
  }
  return ring;
}

/// The handle between the edges of the holes.
void add_handle(TriangleMesh& mesh, const std::vector<int>& low, const std::vector<int>& high) {
  constexpr int kSections = 26;
  std::vector<int> previous = high;
  const auto bridge = [&](const std::vector<int>& next) {
    for (std::size_t i = 0; i < kAround; ++i) {
      const std::size_t j = (i + 1) % kAround;
      add_quad(mesh, previous[i], previous[j], next[j], next[i]);
    }
    previous = next;
  };
  for (int k = 1; k < kSections; ++k) {
    std::vector<int> section;
    for (const Eigen::Vector3d& p : tube_section(static_cast<double>(k) / kSections)) {
      section.push_back(static_cast<int>(mesh.vertices.size()));
      mesh.vertices.push_back(p);
    }
    bridge(section);
  }
  std::vector<int> last;  // the path arrives from outside: the edge runs the other way round
  for (std::size_t i = 0; i < kAround; ++i) last.push_back(low[(kAround - i) % kAround]);
  bridge(last);
}

}  // namespace

TriangleMesh mug_mesh() {
  const Cup shape = cup();
  TriangleMesh mesh = loft({0, 0, 0}, shape.rings, {0, 0, kWall});
  const std::vector<int> low = shape_hole(mesh, shape.hole_rings[0], kLowHole);
  const std::vector<int> high = shape_hole(mesh, shape.hole_rings[1], kHighHole);
  add_handle(mesh, low, high);
  cut_holes(mesh, shape.hole_rings);
  return mesh;
}

}  // namespace palpate::geometry
