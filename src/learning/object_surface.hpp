// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/geometry/mesh.hpp"
#include "palpate/simulation/relocate_object.hpp"

namespace palpate::learning {

/// The surfaces of all parts of an object in one mesh, in the object's frame, for drawing; where
/// parts overlap it is not the surface of their union.
geometry::TriangleMesh surface(const simulation::RelocateObject& object);

}  // namespace palpate::learning
