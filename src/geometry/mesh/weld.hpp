// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// For each vertex the first vertex at exactly the same position (itself, if it is the first).
std::vector<int> first_at_same_position(const TriangleMesh& mesh);

/// The mesh with each vertex i replaced by `target[i]`, in the order of their first use; unused
/// vertices are left out.
TriangleMesh merged(const TriangleMesh& mesh, const std::vector<int>& target);

}  // namespace palpate::geometry
