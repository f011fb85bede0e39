// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "geometry/objects/solids.hpp"
#include "palpate/geometry/objects/shapes.hpp"

namespace palpate::geometry {
namespace {

constexpr double kCell = 0.005;    // m, of the grid from which the surface is extracted
constexpr double kHeadTurn = 0.6;  // rad, to the left: the duck has no plane of symmetry

/// An ellipsoid with its centre at p, turned by `yaw` and raised in front by `pitch`.
Solid ellipsoid(const Eigen::Vector3d& p, const Eigen::Vector3d& half, double yaw = 0,
                double pitch = 0) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(-pitch, Eigen::Vector3d::UnitY()))
                   .toRotationMatrix();
  T.translation() = p;
  return moved(T, superquadric(half, 1, 1));
}

/// Body, raised tail, and wings that stand off; the left one is lifted.
Solid body() {
  Solid solid = ellipsoid({0, 0, 0.025}, {0.038, 0.027, 0.025});
  solid =
      joined(solid, ellipsoid({-0.036, 0.002, 0.037}, {0.016, 0.010, 0.008}, 0.15, -0.6), 0.010);
  solid =
      joined(solid, ellipsoid({-0.006, 0.025, 0.033}, {0.020, 0.007, 0.011}, -0.15, -0.35), 0.003);
  return joined(solid, ellipsoid({-0.006, -0.025, 0.027}, {0.020, 0.007, 0.011}, 0.15, 0), 0.003);
}

/// Head with a flat beak and a crest, about the neck's axis.
Solid head() {
  const Eigen::Vector3d at(0.020, 0, 0.061);
  const auto ahead = [&](double along, double up) {
    return Eigen::Vector3d(at.x() + along * std::cos(kHeadTurn), along * std::sin(kHeadTurn),
                           at.z() + up);
  };
  Solid solid = ellipsoid(at, {0.019, 0.0185, 0.019});
  solid =
      joined(solid, ellipsoid(ahead(0.023, -0.003), {0.012, 0.010, 0.0055}, kHeadTurn, 0), 0.002);
  return joined(solid, ellipsoid(ahead(-0.010, 0.016), {0.011, 0.006, 0.007}, kHeadTurn, -0.7),
                0.004);
}

}  // namespace

TriangleMesh duck_mesh() {
  // A flat bottom, on which it stands.
  const Solid below = [](const Eigen::Vector3d& p) { return p.z() - 0.002; };
  const Solid duck = cut(joined(body(), head(), 0.008), below);
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-0.060, -0.045, -0.005),
                                Eigen::Vector3d(0.060, 0.045, 0.090));
  TriangleMesh mesh = extract_surface(duck, box, kCell);
  for (Eigen::Vector3d& v : mesh.vertices) v.z() -= 0.002;
  return mesh;
}

}  // namespace palpate::geometry
