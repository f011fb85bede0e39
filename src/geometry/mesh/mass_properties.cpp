// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/mesh/mass_properties.hpp"

#include <fmt/format.h>

#include "palpate/core/error.hpp"

namespace palpate::geometry {

MassProperties mass_properties(const TriangleMesh& mesh, double mass) {
  // Tetrahedra from a point amid the mesh: far from the origin the sums would cancel.
  const Eigen::Vector3d apex =
      mesh.vertices.empty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(bounds(mesh).center());
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();   // integral of x
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  // integral of x x'
  for (const auto& [i, j, k] : mesh.triangles) {
    const auto corner = [&](int v) -> Eigen::Vector3d {
      return mesh.vertices[static_cast<std::size_t>(v)] - apex;
    };
    const Eigen::Vector3d a = corner(i), b = corner(j), c = corner(k), sum = a + b + c;
    const double det = a.dot(b.cross(c));
    volume += det / 6;
    first += det / 24 * sum;
    second += det / 120 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  if (!(volume > 0)) {
    throw BadInput(fmt::format("the mesh encloses no volume ({} m^3)", volume));
  }
  const Eigen::Vector3d offset = first / volume;
  const Eigen::Matrix3d covariance = second / volume - offset * offset.transpose();
  MassProperties properties;
  properties.volume = volume;
  properties.centroid = apex + offset;
  properties.inertia = mass * (covariance.trace() * Eigen::Matrix3d::Identity() - covariance);
  return properties;
}

}  // namespace palpate::geometry
