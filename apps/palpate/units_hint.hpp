// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "palpate/core/se3.hpp"

namespace palpate::app {

/// Diagonal of the box around points, m.
double extent_of(const std::vector<Eigen::Vector3d>& points);

/// Whether points that no pose fits may not be in metres: they are more than 100 times as large on
/// one side as on the other or, with a bound, over 10 000 times as large as that. Or that they are
/// fewer than three.
/// @param noise_bound  m; 0: none
/// @return a hint for a person; empty if the sizes suggest nothing
std::string units_hint(const std::vector<Eigen::Vector3d>& source,
                       const std::vector<Eigen::Vector3d>& target, double noise_bound);

}  // namespace palpate::app
