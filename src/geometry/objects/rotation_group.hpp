// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace palpate::geometry {

/// `count` rotations that cover SO(3) evenly: super-Fibonacci spirals (Alexa, CVPR 2022).
std::vector<Eigen::Matrix3d> rotation_grid(int count);

/// Index of the rotation in `set` nearest to R.
std::size_t nearest_rotation(const std::vector<Eigen::Matrix3d>& set, const Eigen::Matrix3d& R);

/// Largest group to be had from approximate elements, identity first, then by angle.
///
/// Elements whose products lead out of the set (farther than `match` rad from every element) are
/// dropped, the later ones first; the rest are averaged, g <- mean over h of (g h) h^-1, which
/// converges to an exact group (Grove, Karcher & Ruh 1974).
/// @param elements  best first; the identity need not be among them
std::vector<Eigen::Matrix3d> nearest_group(std::vector<Eigen::Matrix3d> elements, double match);

}  // namespace palpate::geometry
