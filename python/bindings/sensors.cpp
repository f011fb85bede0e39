// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/optional.h>

#include "arrays.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/tactile/sensors/height_map.hpp"
#include "palpate/tactile/sensors/intrinsic_contact.hpp"
#include "palpate/tactile/sensors/taxel_array.hpp"
#include "without_gil.hpp"

namespace palpate::python {
namespace {

using namespace nb::literals;

Eigen::Isometry3d pose_or_identity(nb::handle T) {
  return is_given(T) ? pose_from(T, "T_frame_sensor") : Eigen::Isometry3d::Identity();
}

Contacts of_height_map(nb::object depth, double pixel, nb::object T, double min_depth, int cell,
                       double min_share, double depth_sigma, double slope_sigma) {
  const tactile::HeightMap map{matrix_from(depth, "depth"), pixel};
  const Eigen::Isometry3d T_frame_sensor = pose_or_identity(T);
  const WithoutGil release;
  return {tactile::contacts_of_height_map(map, T_frame_sensor,
                                          {min_depth, cell, min_share, depth_sigma, slope_sigma})};
}

Contacts of_taxels(nb::object points, nb::object normals, nb::object forces, nb::object T,
                   double min_force, double pitch, double normal_sigma) {
  const auto p = points_from(points, "points"), n = points_from(normals, "normals");
  if (n.size() != p.size()) {
    throw BadInput(fmt::format("normals: {} for {} points", n.size(), p.size()));
  }
  const auto f = numbers_from(forces, p.size(), "forces");
  std::vector<tactile::Taxel> taxels;
  for (std::size_t i = 0; i < p.size(); ++i) taxels.push_back({p[i], n[i], f[i]});
  return {
      tactile::contacts_of_taxels(taxels, pose_or_identity(T), {min_force, pitch, normal_sigma})};
}

Contacts of_wrench(nb::object force, nb::object moment, nb::object a, nb::object b, double radius,
                   nb::object T, double min_force, double force_sigma, double moment_sigma) {
  const auto contact =
      tactile::contact_of_wrench({vector_from(force, "force"), vector_from(moment, "moment")},
                                 {vector_from(a, "a"), vector_from(b, "b"), radius},
                                 pose_or_identity(T), {min_force, force_sigma, moment_sigma});
  return contact ? Contacts{{*contact}} : Contacts{};
}

}  // namespace

void bind_sensors(nb::module_& module) {
  const tactile::HeightMapOptions map;
  module.def(
      "contacts_of_height_map", &of_height_map, "depth"_a, "pixel"_a,
      "T_frame_sensor"_a = nb::none(), nb::kw_only(), "min_depth"_a = map.min_depth,
      "cell"_a = map.cell, "min_share"_a = map.min_share, "depth_sigma"_a = map.depth_sigma,
      "slope_sigma"_a = map.slope_sigma,
      nb::sig("def contacts_of_height_map(depth: numpy.typing.ArrayLike, pixel: float, "
              "T_frame_sensor: numpy.typing.ArrayLike | None = None, *, min_depth: float = 0.0001, "
              "cell: int = 16, min_share: float = 0.5, depth_sigma: float = 5e-05, slope_sigma: "
              "float = 0.1) -> Contacts"),
      "Contacts from the indentation of a gel (GelSight, DIGIT).\n\ndepth (rows, columns): m by "
      "which the gel is pushed in, 0 where nothing touches. pixel: m on the gel. The sensor's "
      "frame "
      "is in the middle of the undeformed surface, x along the columns, y along the rows, z out of "
      "the gel. Each square of cell pixels that touches gives one contact: mean point and normal "
      "of "
      "the plane that fits best.\n\nRaises ValueError for an empty map, one deeper than it "
      "is long, and values that are not finite.");
  const tactile::TaxelOptions taxel;
  module.def(
      "contacts_of_taxels", &of_taxels, "points"_a, "normals"_a, "forces"_a,
      "T_frame_sensor"_a = nb::none(), nb::kw_only(), "min_force"_a = taxel.min_force,
      "pitch"_a = taxel.pitch, "normal_sigma"_a = taxel.normal_sigma,
      nb::sig("def contacts_of_taxels(points: numpy.typing.ArrayLike, normals: "
              "numpy.typing.ArrayLike, forces: numpy.typing.ArrayLike, T_frame_sensor: "
              "numpy.typing.ArrayLike | None = None, *, min_force: float = 0.05, pitch: float = "
              "0.004, normal_sigma: float = 0.35) -> Contacts"),
      "A contact at each taxel of a skin that is pressed.\n\npoints (N, 3), m, and outward unit "
      "normals (N, 3) of the skin in the sensor's frame; forces (N,): of the object on the skin, "
      "N. "
      "pitch: m between taxels.\n\nRaises ValueError, naming the taxel.");
  const tactile::IntrinsicOptions wrench;
  module.def(
      "contact_of_wrench", &of_wrench, "force"_a, "moment"_a, nb::kw_only(), "a"_a, "b"_a,
      "radius"_a, "T_frame_sensor"_a = nb::none(), "min_force"_a = wrench.min_force,
      "force_sigma"_a = wrench.force_sigma, "moment_sigma"_a = wrench.moment_sigma,
      nb::sig(
          "def contact_of_wrench(force: numpy.typing.ArrayLike, moment: numpy.typing.ArrayLike, "
          "*, a: numpy.typing.ArrayLike, b: numpy.typing.ArrayLike, radius: float, "
          "T_frame_sensor: numpy.typing.ArrayLike | None = None, min_force: float = 0.1, "
          "force_sigma: float = 0.02, moment_sigma: float = 0.001) -> Contacts"),
      "The contact that explains what a force-torque sensor in a fingertip measures (Bicchi, "
      "Salisbury & Brock 1993); none below min_force or where the wrench's axis misses the "
      "tip.\n\nforce (3,), N, and moment (3,), N m, of the object on the finger about the sensor's "
      "origin. The tip is a capsule of radius (m) about the segment from a to b (m), a ball where "
      "they are equal.\n\nRaises ValueError for values that are not finite.");
}

}  // namespace palpate::python
