// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>

#include "arrays.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/tactile/normals/normal_estimator.hpp"
#include "pickle.hpp"

namespace palpate::python {

template <>
struct Fields<tactile::NormalEstimate> {
  static auto of(tactile::NormalEstimate& it) {
    return std::tie(it.time, it.status, it.n, it.covariance);
  }
};

namespace {

using namespace nb::literals;

/// The frames of one finger through checks and estimator.
class NormalEstimator {
 public:
  NormalEstimator(const std::string& name, double period)
      : maker_({.period = period}), estimator_(tactile::make_normal_estimator(name)) {}

  tactile::NormalEstimate update(double time, nb::object points, nb::object forces) {
    const auto p = points_from(points, "points"), f = points_from(forces, "forces");
    if (p.size() != f.size()) {
      throw BadInput(fmt::format("forces: {} for {} points", f.size(), p.size()));
    }
    if (!std::isfinite(time)) throw BadInput(fmt::format("time is {}, not finite", time));
    tactile::FingerFrame frame{time, {}};
    for (std::size_t i = 0; i < p.size(); ++i) {
      if (!(p[i].allFinite() && f[i].allFinite())) {
        throw BadInput(fmt::format("contact {}: its point or force is not finite", i));
      }
      frame.contacts.push_back({p[i], f[i], std::nullopt});
    }
    return estimator_->update(maker_.next(frame));
  }

 private:
  tactile::SampleMaker maker_;
  std::unique_ptr<tactile::NormalEstimator> estimator_;
};

}  // namespace

void bind_normals(nb::module_& module) {
  using Estimate = tactile::NormalEstimate;
  nb::class_<Estimate> bound(module, "NormalEstimate",
                             "What is known of the surface at the contact.");
  bind_pickle(bound);
  bound.def_ro("time", &Estimate::time, "s, of the contact that it describes.")
      .def_prop_ro(
          "status",
          [](const Estimate& self) { return std::string(tactile::to_string(self.status)); },
          "'none', 'tracked', or 'held' where the sample was of no use.")
      .def_ro("normal", &Estimate::n, nb::rv_policy::copy,
              "Outward unit normal of the object, (3,); nan without one.")
      .def_prop_ro(
          "covariance",
          [](const Estimate& self) -> std::optional<Rotation3> {
            if (!self.covariance) return std::nullopt;
            return Rotation3(*self.covariance);
          },
          "Of the normal, (3, 3), rad^2; None from estimators without one.")
      .def("__repr__", [](const Estimate& self) {
        return fmt::format("NormalEstimate({}, ({:.3f}, {:.3f}, {:.3f}))",
                           tactile::to_string(self.status), self.n.x(), self.n.y(), self.n.z());
      });
  nb::class_<NormalEstimator>(module, "NormalEstimator",
                              "Follows the normal under one fingertip as it slides and presses.")
      .def(nb::init<const std::string&, double>(), "name"_a = "s2", nb::kw_only(),
           "period"_a = 0.01,
           "An estimator by its name, fed every `period` s.\n\nRaises ValueError for an unknown "
           "name; normal_estimators() lists them.")
      .def("update", &NormalEstimator::update, "time"_a, "points"_a, "forces"_a,
           nb::sig("def update(self, time: float, points: numpy.typing.ArrayLike, forces: "
                   "numpy.typing.ArrayLike) -> NormalEstimate"),
           "Take what the fingertip touches at a time (s): points (N, 3), m, and forces on the "
           "object (N, 3), N, in a frame that does not move; N may be 0.\n\nRaises ValueError for "
           "other shapes, another number of forces, and values that are not finite.")
      .def("__repr__", [](const NormalEstimator&) { return "NormalEstimator()"; });
  module.def(
      "normal_estimators", &tactile::normal_estimators,
      "Names of all estimators: recursive least squares ('rls', corrected, and 'rls-literal', "
      "as printed: thesis eqs 5.1-5.10), plane fits "
      "('tls', 'eigen'), filters on the sphere ('s2', 's2-lag').");
}

}  // namespace palpate::python
