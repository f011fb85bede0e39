// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/posterior.hpp"

#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "libraries.hpp"
#include "localization_fields.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/localization/information/next_touch.hpp"

namespace palpate::python {
namespace {

namespace lo = localization;
using namespace nb::literals;

constexpr int kMostSamples = 1'000'000;

Mode mode_at(const Posterior& posterior, std::size_t index) {
  return {posterior.found.modes.at(index), posterior.model->object().T_mesh_object.inverse()};
}

std::vector<Mode> modes_of(const Posterior& posterior) {
  std::vector<Mode> modes;
  for (std::size_t i = 0; i < posterior.found.modes.size(); ++i) {
    modes.push_back(mode_at(posterior, i));
  }
  return modes;
}

std::string repr(const Mode& mode) {
  const Eigen::Isometry3d& T = mode.mode.T_frame_object;
  const Eigen::Vector3d w = log_so3(T.linear()) / kDegree, t = 1e3 * T.translation();
  return fmt::format(
      "Mode(weight {:.3f}, probability {:.3f}, rotation ({:.1f}, {:.1f}, {:.1f}) deg, translation "
      "({:.1f}, {:.1f}, {:.1f}) mm{})",
      mode.mode.weight, lo::pose_probability(mode.mode), w.x(), w.y(), w.z(), t.x(), t.y(), t.z(),
      mode.mode.free_axis
          ? fmt::format(", free by {:.0f} deg", mode.mode.free_axis->extent / kDegree)
          : "");
}

std::string repr(const Posterior& posterior) {
  return fmt::format("Posterior({}, probability {:.3f}, {} modes, {:.0f} ms)",
                     lo::to_string(posterior.found.status), lo::best_probability(posterior.found),
                     posterior.found.modes.size(), 1e3 * posterior.found.seconds);
}

void bind_mode(nb::module_& module) {
  nb::class_<lo::FreeAxis> free_axis(module, "FreeAxis",
                                     "Credible poses: turns about a line by -extent..+extent.");
  bind_pickle(free_axis);
  free_axis
      .def_ro("point", &lo::FreeAxis::point, nb::rv_policy::copy,
              "On the line, contacts' frame, (3,), m.")
      .def_ro("direction", &lo::FreeAxis::direction, nb::rv_policy::copy, "(3,), unit.")
      .def_ro("extent", &lo::FreeAxis::extent, "rad to either side; pi: all round.")
      .def_ro("share", &lo::FreeAxis::share,
              "Of the mode's weight within 5 deg and 10 mm of its pose; None: not known.")
      .def("__repr__", [](const lo::FreeAxis& self) {
        return fmt::format("FreeAxis(({:.3f}, {:.3f}, {:.3f}), +- {:.0f} deg)", self.direction.x(),
                           self.direction.y(), self.direction.z(), self.extent / kDegree);
      });
  nb::class_<Mode> mode(module, "Mode", "A cluster of credible poses.");
  bind_pickle(mode);
  mode.def_prop_ro(
          "T_frame_object", [](const Mode& self) { return pose(self.mode.T_frame_object); },
          "Object (origin at its volume centroid) to the contacts' frame, (4, 4).")
      .def_prop_ro(
          "T_frame_mesh",
          [](const Mode& self) { return pose(self.mode.T_frame_object * self.T_object_mesh); },
          "The mesh file's own coordinates to the contacts' frame, (4, 4).")
      .def_prop_ro(
          "weight", [](const Mode& self) { return self.mode.weight; },
          "Share of the posterior's mass.")
      .def_prop_ro(
          "probability", [](const Mode& self) { return lo::pose_probability(self.mode); },
          "That the object is within 5 deg and 10 mm of this pose, modulo its symmetries.")
      .def_prop_ro(
          "covariance", [](const Mode& self) { return Covariance6(self.mode.covariance); },
          "Of [rotation; translation] of T_frame_object, frame's axes, (6, 6), rad and m.")
      .def_prop_ro(
          "family_covariance",
          [](const Mode& self) { return Covariance6(lo::family_covariance(self.mode)); },
          "The same, rad and m, with an even spread along the free axis, if there is one.")
      .def_prop_ro(
          "free_axis", [](const Mode& self) { return self.mode.free_axis; },
          "A free turn, or None.")
      .def("__repr__", [](const Mode& self) { return repr(self); });
}

nb::object sample(const Posterior& posterior, int count, std::uint64_t seed) {
  if (count < 1 || count > kMostSamples) {
    throw BadInput(fmt::format("count is {}, not 1 to {}", count, kMostSamples));
  }
  if (posterior.found.modes.empty()) throw BadInput("no pose explains the contacts: no samples");
  RandomStream random(seed, "sample");
  Matrix poses(4 * count, 4);
  Eigen::Index row = 0;
  for (const auto& T : lo::draw_poses(posterior.found, count, random)) {
    poses.middleRows<4>(row) = T.matrix();
    row += 4;
  }
  return nb::cast(std::move(poses)).attr("reshape")(count, 4, 4);
}

}  // namespace

void bind_posterior(nb::module_& module) {
  bind_mode(module);
  nb::class_<Posterior> posterior(module, "Posterior",
                                  "What is known of the object's pose: modes, heaviest first.");
  bind_pickle(posterior);
  posterior
      .def_prop_ro(
          "status",
          [](const Posterior& self) { return std::string(lo::to_string(self.found.status)); },
          "'certain', 'ambiguous' or 'no_pose'.")
      .def_prop_ro(
          "probability", [](const Posterior& self) { return lo::best_probability(self.found); },
          "Of the best pose, within 5 deg and 10 mm modulo symmetry; 0 without one.")
      .def_prop_ro("modes", &modes_of, "Heaviest first; equal poses of a symmetric object once.")
      .def_prop_ro(
          "best",
          [](const Posterior& self) -> std::optional<Mode> {
            if (self.found.modes.empty()) return std::nullopt;
            return mode_at(self, 0);
          },
          "The heaviest mode; None where no pose explains the contacts.")
      .def_prop_ro(
          "residual_set",
          [](const Posterior& self) {
            std::vector<Pose4> result;
            for (const auto& T : self.found.residual_set) result.push_back(pose(T));
            return result;
          },
          "Where the modes hold less than 95 %: poses (4, 4) whose surroundings hold the "
          "rest up to there.")
      .def_prop_ro(
          "credible_mass", [](const Posterior& self) { return self.found.credible_mass; },
          "Posterior mass of the modes and the residual set together: 0.95 or more, or, where "
          "the samples hold less, a cautious estimate of what they hold; 0 without modes.")
      .def_prop_ro(
          "residual_mass", [](const Posterior& self) { return self.found.residual_mass(); },
          "What the modes' weights lack of 1.")
      .def_prop_ro(
          "seconds", [](const Posterior& self) { return self.found.seconds; }, "s.")
      .def(
          "covers",
          [](const Posterior& self, nb::object truth) {
            return lo::covers(self.found, pose_from(truth, "truth"),
                              self.model->object().symmetries);
          },
          "truth"_a, nb::sig("def covers(self, truth: numpy.typing.ArrayLike) -> bool"),
          "Whether the truth (4, 4), T_frame_object, is within 5 deg and 10 mm of the smallest "
          "set of modes that holds 95 %.\n\nRaises ValueError unless the truth is a pose.")
      .def("sample", &sample, "count"_a, nb::kw_only(), "seed"_a = 0,
           nb::sig("def sample(self, count: int, *, seed: int = 0) -> "
                   "numpy.typing.NDArray[numpy.float64]"),
           "Poses (count, 4, 4), T_frame_object, drawn from the modes by their weights: normal "
           "about each, even along a free axis. What the modes lack of 1 (residual_mass) is in "
           "none of them.\n\nRaises ValueError without modes and for a count that is not 1 to "
           "1000000.")
      .def(
          "error",
          [](const Posterior& self, nb::object truth) -> std::optional<std::pair<double, double>> {
            if (self.found.modes.empty()) return std::nullopt;
            const auto error =
                lo::pose_error(self.found.modes.front().T_frame_object, pose_from(truth, "truth"),
                               self.model->object().symmetries);
            return std::pair{error.rotation, error.translation};
          },
          "truth"_a,
          nb::sig("def error(self, truth: numpy.typing.ArrayLike) -> tuple[float, float] | None"),
          "Of the best pose from the truth (4, 4), modulo symmetry: rad, m; None without "
          "one.\n\nRaises ValueError unless the truth is a pose.")
      .def("__repr__", [](const Posterior& self) { return repr(self); })
      .def("_repr_html_", &posterior_html);
}

}  // namespace palpate::python
