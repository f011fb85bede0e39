// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

struct FilledHoles {
  int count = 0;
  int triangles = 0;   ///< added
  int max_edges = 0;   ///< of one hole
  double largest = 0;  ///< diagonal of the bounds of a hole's rim, m
};

/// Closes each loop of boundary edges by cutting it into triangles or, where the loop is too
/// contorted for that, by a fan around its centre. A loop of more than 1000 edges, or one that
/// meets itself, stays open.
FilledHoles fill_holes(TriangleMesh& mesh);

}  // namespace palpate::geometry
