// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/geometry/query/mesh_query.hpp"

namespace palpate::app {

/// What the simulator may collide with in place of an object's surface.
enum class Representation {
  hull,   ///< convex hull, the simulator's default for meshes
  parts,  ///< convex parts (CoACD)
  sdf,    ///< signed distance field
  flex,   ///< rigid two-dimensional flex
  exact   ///< the true surface, as the fingertips here meet it
};
inline constexpr std::array<Representation, 5> kRepresentations = {
    Representation::hull, Representation::parts, Representation::sdf, Representation::flex,
    Representation::exact};
std::string_view to_string(Representation representation);

/// A ball of a fingertip's size just within the surface, and where it truly touches.
struct TestSphere {
  Eigen::Vector3d center;        ///< of the ball, m
  geometry::ClosestPoint touch;  ///< of the true surface to the center, which is outside
};

/// Balls about points of the surface, spread by area, each `depth` within it at its nearest point.
/// @throws BadInput unless there are points, 0 < depth < radius, and there is room for the balls
std::vector<TestSphere> place_test_spheres(const geometry::MeshQuery& mesh, int count,
                                           double radius, double depth, RandomStream random);

/// How a representation's deepest contacts with the probes differ from the true ones.
struct RepresentationResult {
  std::vector<double> angles;   ///< rad, between the normals; of the probes that met
  std::vector<double> offsets;  ///< m, between the points on the surface
  std::vector<double> depths;   ///< m
  int missed = 0;               ///< probes without a contact
  double prepare_seconds = 0;   ///< of the processor, to make the model
  double call_seconds = 0;      ///< of the processor, for all that depends on positions, a probe
};

/// The true meeting is mesh.closest_point(); the simulator's contact depends on it in no way but
/// for `exact`, whose collider is under test. The signed distance field is that of the simulator
/// itself.
/// @param radius  of the probes, m
/// @throws BadInput for no probes, or if the simulator refuses the mesh
RepresentationResult measure_representation(Representation representation,
                                            const geometry::MeshQuery& mesh,
                                            const std::vector<TestSphere>& probes, double radius);

}  // namespace palpate::app
