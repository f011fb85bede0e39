// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// A closed random shape of household size, the same for a seed everywhere: a superquadric, a loft,
/// or a profile revolved, solid or hollow with a thin wall, with parts added or cut away and
/// perhaps a handle; nearly symmetric ones have their symmetry broken by 0 to 6 mm. The surface
/// bears the error of a scan, 0.3 mm rms over 6 to 25 mm, and 1 to 50 thousand triangles.
/// @return watertight, one piece, 40 to 220 mm long, m
TriangleMesh generated_shape(std::uint64_t seed);

/// The seed of an object's name `generated:SEED`; nothing for another kind of name.
/// @throws BadInput where no whole number from 0 on follows the colon
std::optional<std::uint64_t> generated_seed(std::string_view name);

/// The names with each range `generated:A-B` replaced by all names from A to B.
/// @throws BadInput for a range that is empty or of more than 10000 names
std::vector<std::string> expand_object_names(const std::vector<std::string>& names);

}  // namespace palpate::geometry
