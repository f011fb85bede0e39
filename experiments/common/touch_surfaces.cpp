// SPDX-License-Identifier: Apache-2.0
#include "touch_surfaces.hpp"

#include <fmt/format.h>

#include <cmath>

#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "tactile/sliding.hpp"

namespace palpate::experiment {
namespace {

constexpr double kWide = 0.08, kHigh = 0.12;  // m, of the box
constexpr double kBall = 0.05, kBase = 0.04;  // m, radius of the dome, height of its foot
constexpr int kColumns = 120, kRings = 40;

/// Half a ball on a cylinder, standing on z = 0.
geometry::TriangleMesh dome_mesh() {
  geometry::TriangleMesh mesh;
  const auto ring = [&](double radius, double z) {
    for (int i = 0; i < kColumns; ++i) {
      const double angle = 2 * kPi * i / kColumns;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  };
  mesh.vertices.emplace_back(0, 0, 0);
  ring(kBall, 0);
  for (int i = 0; i < kRings; ++i) {
    const double angle = kPi / 2 * i / kRings;
    ring(kBall * std::cos(angle), kBase + kBall * std::sin(angle));
  }
  mesh.vertices.emplace_back(0, 0, kBase + kBall);
  const int top = static_cast<int>(mesh.vertices.size()) - 1;
  const auto at = [](int of_ring, int i) { return 1 + of_ring * kColumns + i % kColumns; };
  for (int i = 0; i < kColumns; ++i) {
    mesh.triangles.push_back({0, at(0, i + 1), at(0, i)});
    for (int r = 0; r < kRings; ++r) {
      mesh.triangles.push_back({at(r, i), at(r, i + 1), at(r + 1, i + 1)});
      mesh.triangles.push_back({at(r, i), at(r + 1, i + 1), at(r + 1, i)});
    }
    mesh.triangles.push_back({at(kRings, i), at(kRings, i + 1), top});
  }
  return mesh;
}

Eigen::Vector2d lissajous(double t) {
  return {0.025 * std::sin(2 * kPi * t / 8), 0.025 * std::sin(2 * kPi * t / 5.3 + 1)};
}

void add_on_flat(double t, double radius, TipPath& path) {
  const Eigen::Vector2d q = lissajous(t);
  path.normal.push_back(Eigen::Vector3d::UnitZ());
  path.center.emplace_back(q.x(), q.y(), kHigh + radius);
}

void add_on_dome(double t, double radius, TipPath& path) {
  const Eigen::Vector2d angle = lissajous(t) / kBall;
  const double tilt = angle.norm();
  const Eigen::Vector2d out =
      tilt > 1e-9 ? Eigen::Vector2d(angle / tilt) : Eigen::Vector2d::UnitX();
  path.normal.emplace_back(std::sin(tilt) * out.x(), std::sin(tilt) * out.y(), std::cos(tilt));
  path.center.push_back(Eigen::Vector3d(0, 0, kBase) + (kBall + radius) * path.normal.back());
}

/// Over the box's edge y = x_edge, or about its corner, both of which point against x.
void add_over_edges(double t, double radius, bool corner, TipPath& path) {
  const double u = 0.022 * std::sin(2 * kPi * t / 8 - 0.6);
  const double w =
      corner ? 0.02 * std::sin(2 * kPi * t / 6.1 + 2) : 0.02 * std::sin(2 * kPi * t / 5.3);
  tactile::SlidingPath local;
  const Eigen::Vector3d over_edge(std::min(u, 0.0), w - kWide / 2, std::min(-u, 0.0));
  tactile::add_rounded(corner ? tactile::fold_onto_corner(u, w) : over_edge, radius, local);
  // From the solid grown by the tip to the box that it was grown from.
  const Eigen::Vector3d to_box(kWide / 2 + radius, corner ? kWide / 2 + radius : kWide / 2,
                               kHigh + radius);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(corner ? 0.75 * kPi : kPi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  path.normal.push_back(R * local.n[0]);
  path.center.push_back(R * (local.p[0] + to_box));
}

}  // namespace

simulation::WorldOptions sliding_world() {
  simulation::WorldOptions options;
  options.stiffness_scale = 20;
  return options;
}

TouchedSurface touched_surface(const std::string& name) {
  const auto box = [] { return fixed_object("box", geometry::box_mesh({kWide, kWide, kHigh})); };
  const Eigen::Vector3d up(0, 0, 1);
  const double half = std::sqrt(0.5);
  if (name == "flat") return {name, box(), {}, {up}};
  if (name == "edge") return {name, box(), {.yaw = kPi}, {up, {-1, 0, 0}}};
  if (name == "corner") {
    return {name, box(), {.yaw = 0.75 * kPi}, {up, {-half, half, 0}, {-half, -half, 0}}};
  }
  if (name == "smooth") return {name, fixed_object("dome", dome_mesh()), {}, {}};
  throw BadInput(fmt::format("no surface is called '{}'", name));
}

TipPath path_over(const TouchedSurface& surface, double tip_radius, double seconds) {
  TipPath path;
  for (int i = 0; i * hand::kTick < seconds; ++i) {
    const double t = i * hand::kTick;
    if (surface.name == "flat") {
      add_on_flat(t, tip_radius, path);
    } else if (surface.name == "smooth") {
      add_on_dome(t, tip_radius, path);
    } else {
      add_over_edges(t, tip_radius, surface.name == "corner", path);
    }
  }
  return path;
}

}  // namespace palpate::experiment
