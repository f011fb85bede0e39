// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::simulation {

/// The mesh with fewer triangles: vertices move onto neighbours, in the order of their quadric
/// error (Garland & Heckbert, SIGGRAPH 1997), until a move would cost more than `error` or
/// `triangles` are left. The surface stays a manifold of its kind, and no triangle folds over.
/// @param mesh   watertight, m
/// @param error  m, root mean square distance of a vertex to the planes that met in it
geometry::TriangleMesh decimated(const geometry::TriangleMesh& mesh, std::size_t triangles,
                                 double error);

}  // namespace palpate::simulation
