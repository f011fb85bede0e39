// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <string>
#include <vector>

#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::python {

/// A mesh with the tree that its queries need; shared, for objects hand out theirs.
using SharedMesh = std::shared_ptr<const geometry::MeshQuery>;
struct Mesh {
  SharedMesh query;
  const geometry::TriangleMesh& triangles() const { return query->mesh(); }
};

/// Contacts from whatever sensor.
struct Contacts {
  std::vector<tactile::Contact> list;
};

/// A posterior with what is needed to show it: the mesh's own frame and some of its surface.
struct Posterior {
  localization::Posterior found;
  std::shared_ptr<const geometry::ObjectModel> model;
};
struct Mode {
  localization::Mode mode;
  Eigen::Isometry3d T_object_mesh;
};

void bind_geometry(nanobind::module_& module);
void bind_hand_description(nanobind::module_& module);
void bind_hand(nanobind::module_& module);
void bind_registration(nanobind::module_& module);
void bind_clouds(nanobind::module_& module);
void bind_contacts(nanobind::module_& module);
void bind_sensors(nanobind::module_& module);
void bind_normals(nanobind::module_& module);
void bind_posterior(nanobind::module_& module);
void bind_localization(nanobind::module_& module);
void bind_free_space(nanobind::module_& module);
void bind_identification(nanobind::module_& module);
void bind_estimation(nanobind::module_& module);
void bind_touches(nanobind::module_& module);

/// @throws BadInput for a posterior of another object
void require_same_object(const Posterior& posterior, const geometry::ObjectModel& model);

/// How a posterior draws itself in a notebook: a table of its modes, and the object's surface at
/// each, seen from above and from the side.
std::string posterior_html(const Posterior& posterior);

}  // namespace palpate::python
