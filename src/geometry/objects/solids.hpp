// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "geometry/objects/implicit_surface.hpp"
#include "palpate/core/random.hpp"

namespace palpate::geometry {

/// Superquadric (Barr 1981) about the origin.
/// @param half  half axes, m
/// @param e1, e2  exponents of the profile and of the cross-section: 1 round, towards 0 square
Solid superquadric(const Eigen::Vector3d& half, double e1, double e2);

/// A cross-section |x/a|^(2/e) + |y/b|^(2/e) = 1 along z from -h to h, which narrows towards the
/// top by the share `taper`, turns by `twist` rad and bends sideways by `bend` m.
struct Loft {
  double a = 0.03, b = 0.02, h = 0.05;  ///< m
  double e = 1, taper = 0, twist = 0, bend = 0;
};
Solid lofted(const Loft& loft);

/// Profile revolved about z from -h to h: radii (m) at even heights, a cubic between them.
Solid revolved(std::vector<double> radii, double h);

/// A tube of the given radius along a half ellipse from (x, z0) out by `reach` and back to (x, z1),
/// in the plane y = 0.
Solid handle(double x, double reach, double z0, double z1, double radius);

Solid moved(const Eigen::Isometry3d& T, Solid solid);
/// Union, with a fillet of that radius (m).
Solid joined(Solid a, Solid b, double fillet);
Solid cut(Solid a, Solid b);  ///< a without b
/// The solid's outer layer of that thickness, open above `top`, m.
Solid hollowed(Solid solid, double wall, double top);
/// The solid with its surface displaced by smooth noise of that rms (m), of 6 to 25 mm length.
Solid scanned(Solid solid, double rms, RandomStream random);

}  // namespace palpate::geometry
