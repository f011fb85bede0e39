// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>
#include <utility>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::simulation {

/// Joins a pole, rings 1 to rings - 1 of `sectors` vertices, and the other pole.
inline void add_ring_triangles(geometry::TriangleMesh& mesh, int rings, int sectors) {
  const int last = static_cast<int>(mesh.vertices.size()) - 1;
  const auto at = [&](int ring, int k) { return 1 + (ring - 1) * sectors + k % sectors; };
  for (int k = 0; k < sectors; ++k) {
    mesh.triangles.push_back({0, at(1, k), at(1, k + 1)});
    for (int ring = 1; ring + 1 < rings; ++ring) {
      mesh.triangles.push_back({at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)});
      mesh.triangles.push_back({at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)});
    }
    mesh.triangles.push_back({at(rings - 1, k), last, at(rings - 1, k + 1)});
  }
}

/// A ball of 40 mm with bumps of 2 mm, of about `triangles` triangles between its poles.
inline geometry::TriangleMesh bumpy_ball(int triangles) {
  const int rings = static_cast<int>(std::sqrt(triangles / 4.0)), sectors = 2 * rings;
  geometry::TriangleMesh mesh;
  const auto add = [&](double polar, double azimuth) {
    const double r = 0.04 + 0.002 * std::sin(9 * polar) * std::sin(7 * azimuth) * std::sin(polar);
    mesh.vertices.emplace_back(r * std::sin(polar) * std::cos(azimuth),
                               r * std::sin(polar) * std::sin(azimuth), r * std::cos(polar));
  };
  add(0, 0);
  for (int ring = 1; ring < rings; ++ring) {
    for (int k = 0; k < sectors; ++k) {
      add(std::numbers::pi * ring / rings, 2 * std::numbers::pi * k / sectors);
    }
  }
  add(std::numbers::pi, 0);
  add_ring_triangles(mesh, rings, sectors);
  return mesh;
}

/// A banana: a tube of 17 mm radius that thins out to its ends, bent by `bend` rad over 170 mm.
inline geometry::TriangleMesh bent_tube(double bend, int rings, int sectors) {
  constexpr double kRadius = 0.017, kLength = 0.17;  // m
  geometry::TriangleMesh mesh;
  const auto add = [&](double along, double azimuth) {  // along: -1 to 1
    const double radius = kRadius * std::sqrt(1 - std::pow(along, 4));
    const double angle = bend * along / 2, arm = kLength / bend + radius * std::cos(azimuth);
    mesh.vertices.emplace_back(arm * std::cos(angle), arm * std::sin(angle),
                               radius * std::sin(azimuth));
  };
  add(-1, 0);
  for (int ring = 1; ring < rings; ++ring) {
    for (int k = 0; k < sectors; ++k) {
      add(-std::cos(std::numbers::pi * ring / rings), 2 * std::numbers::pi * k / sectors);
    }
  }
  add(1, 0);
  add_ring_triangles(mesh, rings, sectors);
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

/// A slab of 100 x 100 x 20 mm with its top at z = 0, each face cut into cells x cells squares.
inline geometry::TriangleMesh gridded_slab(int cells) {
  geometry::TriangleMesh mesh;
  const Eigen::Vector3d half(0.05, 0.05, 0.01), center(0, 0, -0.01);
  const auto add_face = [&](int axis, double side) {
    const int first = static_cast<int>(mesh.vertices.size());
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i <= cells; ++i) {
      for (int j = 0; j <= cells; ++j) {
        Eigen::Vector3d p = Eigen::Vector3d::Zero();
        p[axis] = side * half[axis];
        p[u] = half[u] * (2.0 * i / cells - 1);
        p[v] = half[v] * (2.0 * j / cells - 1);
        mesh.vertices.emplace_back(center + p);
      }
    }
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells; ++j) {
        const int a = first + i * (cells + 1) + j, b = a + cells + 1;
        if (side > 0) {
          mesh.triangles.push_back({a, b, b + 1});
          mesh.triangles.push_back({a, b + 1, a + 1});
        } else {
          mesh.triangles.push_back({a, b + 1, b});
          mesh.triangles.push_back({a, a + 1, b + 1});
        }
      }
    }
  };
  for (int axis = 0; axis < 3; ++axis) {
    add_face(axis, 1);
    add_face(axis, -1);
  }
  return mesh;
}

}  // namespace palpate::simulation
