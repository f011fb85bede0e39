// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// Turns faces so that neighbours over two-faced edges wind to the same side, in each connected
/// part to that of the majority. Returns how many were turned.
/// @throws BadInput if a part is one-sided (a Moebius strip)
int make_winding_consistent(TriangleMesh& mesh);

/// Gives sheets that meet in an edge or a vertex vertices of their own, so that around each vertex
/// there is one fan of faces. At an edge of more than two faces those that enclose a wedge of the
/// solid stay together. Unused vertices are left out.
/// @return how many vertices it added to those in use
int separate_sheets(TriangleMesh& mesh);

}  // namespace palpate::geometry
