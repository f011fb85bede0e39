// SPDX-License-Identifier: Apache-2.0
#include "evidence.hpp"

#include <fmt/format.h>
#include <nanobind/stl/string.h>

#include <string>

#include "arrays.hpp"
#include "palpate/core/error.hpp"
#include "palpate/localization/free_space.hpp"
#include "without_gil.hpp"

namespace palpate::python {

namespace lo = localization;
using namespace nb::literals;

std::vector<lo::FreeSphere> spheres_from(nb::handle free_space) {
  std::vector<lo::FreeSphere> spheres;
  if (!is_given(free_space)) return spheres;
  const Matrix rows = matrix_from(free_space, "free_space");
  if (rows.size() == 0) return spheres;
  if (rows.cols() != 4) {
    throw BadInput(fmt::format("free_space has shape ({}, {}), not (N, 4): x, y, z, radius",
                               rows.rows(), rows.cols()));
  }
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    spheres.push_back({rows.row(i).head<3>().transpose(), rows(i, 3)});
  }
  return spheres;
}

namespace {

/// Rows nx, ny, nz, height and, optionally, sigma; none for None.
/// @throws BadInput for another shape
std::vector<lo::PlaneContact> planes_from(nb::handle planes) {
  std::vector<lo::PlaneContact> list;
  if (!is_given(planes)) return list;
  const Matrix rows = matrix_from(planes, "planes");
  if (rows.size() == 0) return list;
  if (rows.cols() != 4 && rows.cols() != 5) {
    throw BadInput(
        fmt::format("planes has shape ({}, {}), not (N, 4) or (N, 5): nx, ny, nz, "
                    "height, sigma",
                    rows.rows(), rows.cols()));
  }
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    lo::PlaneContact plane{rows.row(i).head<3>().transpose(), rows(i, 3)};
    if (rows.cols() == 5) plane.sigma = rows(i, 4);
    list.push_back(plane);
  }
  return list;
}

}  // namespace

lo::Evidence evidence_from(const Contacts& contacts, const EvidenceArguments& arguments) {
  lo::Evidence evidence;
  evidence.contacts = contacts.list;
  evidence.table = arguments.table;
  evidence.free_space = spheres_from(arguments.free_space);
  evidence.planes = planes_from(arguments.planes);
  evidence.false_contact_share = arguments.false_contacts;
  evidence.noise_scale_prior = arguments.noise_scale_prior;
  evidence.size_prior = arguments.size_prior;
  evidence.surface_sigma = arguments.surface_sigma;
  return evidence;
}

namespace {

/// free (X, Y, Z), bool. @throws BadInput for another shape
lo::FreeVoxels voxels_from(nb::handle free, double pitch, nb::handle T_frame_grid) {
  const nb::module_ numpy = nb::module_::import_("numpy");
  require_real(free, "free");
  const nb::object array = numpy.attr("asarray")(free);
  const nb::object type = array.attr("dtype");
  if (nb::cast<std::string>(type.attr("kind")) != "b") {
    throw BadInput(fmt::format("free holds {}, not bool: only what is known to be free is true",
                               nb::str(type).c_str()));
  }
  if (nb::cast<int>(array.attr("ndim")) != 3) {
    throw BadInput(
        fmt::format("free has shape {}, not (X, Y, Z)", nb::repr(array.attr("shape")).c_str()));
  }
  using Bools = nb::ndarray<const bool, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
  const auto cells = nb::cast<Bools>(numpy.attr("ascontiguousarray")(array));
  lo::FreeVoxels voxels;
  for (std::size_t i = 0; i < 3; ++i) {
    voxels.size[static_cast<Eigen::Index>(i)] = static_cast<int>(cells.shape(i));
  }
  voxels.free.assign(cells.data(), cells.data() + cells.size());
  voxels.pitch = pitch;
  if (is_given(T_frame_grid)) voxels.T_frame_grid = pose_from(T_frame_grid, "T_frame_grid");
  return voxels;
}

/// Rows x, y, z, radius.
Matrix free_space_of_voxels(nb::object free, double pitch, nb::object T_frame_grid) {
  const lo::FreeVoxels voxels = voxels_from(free, pitch, T_frame_grid);
  const WithoutGil release;
  const auto spheres = lo::free_spheres_of(voxels);
  Matrix rows(static_cast<Eigen::Index>(spheres.size()), 4);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const lo::FreeSphere& sphere = spheres[static_cast<std::size_t>(i)];
    rows.row(i) << sphere.center.transpose(), sphere.radius;
  }
  return rows;
}

}  // namespace

void bind_free_space(nb::module_& module) {
  module.def(
      "free_space_of_voxels", &free_space_of_voxels, "free"_a, "pitch"_a,
      "T_frame_grid"_a = nb::none(),
      nb::sig("def free_space_of_voxels(free: numpy.typing.ArrayLike, pitch: float, T_frame_grid: "
              "numpy.typing.ArrayLike | None = None) -> numpy.typing.NDArray[numpy.float64]"),
      "Balls, rows x, y, z, radius (N, 4), m, that lie in the free voxels of a grid; "
      "localize(free_space=) takes them, and those of several grids, one below the other.\n\nfree "
      "(X, Y, Z), bool: true where nothing of the object is; what is not known is false. pitch: "
      "m, of a voxel. T_frame_grid (4, 4): the grid's frame, its axes along the indices, its "
      "origin the outer corner of voxel 0, 0, 0; the identity if not given. Voxels are joined to "
      "cubes of 2, 4, 8.. as far as all of one are free, each of which gives the ball inside it; "
      "so a ball never says more than the voxels do, and the corners are left out.\n\nRaises "
      "ValueError for another shape, a pitch that is not positive and finite, what is no "
      "pose, and values that are not bool.");
}

}  // namespace palpate::python
