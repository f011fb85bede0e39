// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/mesh.hpp"

namespace palpate::geometry {

/// For each vertex the first vertex at exactly the same position (itself, if it is the first).
std::vector<int> first_at_same_position(const TriangleMesh& mesh);

}  // namespace palpate::geometry
