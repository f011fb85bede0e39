// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::simulation {

/// Convex parts whose union is nearly the mesh: collision-aware decomposition (Wei et al., SIGGRAPH
/// 2022; concavity 0.05, at most 256 vertices a part). The same mesh gives the same parts.
///
/// Bodies that are not connected are decomposed one by one; a closed cavity counts as filled.
/// Slow (seconds), so the parts are kept in the cache under the mesh's content. Threads may call it
/// at once; they wait for one another.
/// @param mesh  watertight, m
/// @throws BadInput for a mesh without triangles or of more than 200 bodies, or if no part is found
std::vector<geometry::TriangleMesh> convex_parts(const geometry::TriangleMesh& mesh);

}  // namespace palpate::simulation
