// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "geometry/mesh/loft.hpp"
#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

/// Prism over a counter-clockwise polygon in the xy plane, from z = 0 to `height`. The polygon must
/// be visible from its vertex `apex`, from which both caps fan out.
TriangleMesh prism(const std::vector<Eigen::Vector2d>& polygon, int apex, double height) {
  TriangleMesh mesh;
  const int n = static_cast<int>(polygon.size());
  for (double z : {0.0, height}) {
    for (const Eigen::Vector2d& p : polygon) mesh.vertices.emplace_back(p.x(), p.y(), z);
  }
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    add_quad(mesh, i, next, n + next, n + i);
    if (i == apex || next == apex) continue;
    mesh.triangles.push_back({apex, next, i});
    mesh.triangles.push_back({n + apex, n + i, n + next});
  }
  return mesh;
}

/// Half axes of the bottle's cross-section at a height, m.
struct Section {
  double z, a, b;
};

std::vector<Section> bottle_sections() {
  constexpr double kA = 0.048, kB = 0.033;                            // body
  constexpr double kShoulder = 0.118, kNeckZ = 0.158, kNeck = 0.015;  // where the shoulder runs
  std::vector<Section> sections = {
      {0, kA - 0.005, kB - 0.005}, {0.0015, kA - 0.0015, kB - 0.0015}, {0.005, kA, kB}};
  for (double z : {0.03, 0.06, 0.09}) sections.push_back({z, kA, kB});
  constexpr int kSteps = 10;
  for (int i = 0; i <= kSteps; ++i) {  // a quarter of an ellipse from the body to the neck
    const double angle = std::numbers::pi / 2 * i / kSteps;
    const double c = std::cos(angle), s = std::sin(angle);
    sections.push_back(
        {kShoulder + (kNeckZ - kShoulder) * s, kNeck + (kA - kNeck) * c, kNeck + (kB - kNeck) * c});
  }
  const std::pair<double, double> cap_and_nozzle[] = {
      {0.160, 0.015},  {0.1605, 0.018}, {0.162, 0.019},  {0.170, 0.019},
      {0.1715, 0.018}, {0.172, 0.011},  {0.188, 0.0065}, {0.190, 0.0045}};
  for (const auto& [z, radius] : cap_and_nozzle) sections.push_back({z, radius, radius});
  return sections;
}

}  // namespace

TriangleMesh bottle_mesh() {
  constexpr int kColumns = 74;  // not a multiple of 4: lying, it rests on a face, not on an edge
  std::vector<Ring> rings;
  for (const Section& s : bottle_sections()) rings.push_back(ellipse(s.a, s.b, s.z, kColumns));
  return loft({0, 0, 0}, rings, {0, 0, 0.190});
}

TriangleMesh box_mesh(const Eigen::Vector3d& size) {
  if (!size.allFinite() || size.minCoeff() <= 0) {
    throw BadInput(fmt::format("a box needs positive edge lengths, not {} x {} x {} m", size.x(),
                               size.y(), size.z()));
  }
  const double x = size.x() / 2, y = size.y() / 2;
  TriangleMesh mesh = prism({{-x, -y}, {x, -y}, {x, y}, {-x, y}}, 0, size.z());
  for (Eigen::Vector3d& v : mesh.vertices) v.z() -= size.z() / 2;
  return mesh;
}

TriangleMesh bracket_mesh() {
  constexpr double kLong = 0.120, kShort = 0.080, kThick = 0.020, kWide = 0.040;
  constexpr int kInnerCorner = 3;
  return prism(
      {{0, 0}, {kLong, 0}, {kLong, kThick}, {kThick, kThick}, {kThick, kShort}, {0, kShort}},
      kInnerCorner, kWide);
}

}  // namespace palpate::geometry
