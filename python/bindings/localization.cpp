// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <limits>
#include <mutex>

#include "arrays.hpp"
#include "evidence.hpp"
#include "libraries.hpp"
#include "localization_fields.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/option_check.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/localization/pose_prior.hpp"
#include "palpate/localization/tracking/tracker.hpp"
#include "shared_model.hpp"
#include "without_gil.hpp"

namespace palpate::python {
namespace {

namespace lo = localization;
using namespace nb::literals;

constexpr double kLeast = std::numeric_limits<double>::min();  // that is positive

void check_length(const char* what, double value, double least) {
  if (value >= least && value <= kMaxLength) return;
  throw BadInput(fmt::format("{} is {}, not {} and at most {}", what, value,
                             least > 0 ? "positive" : ">= 0", kMaxLength));
}

lo::TableSupport make_table(nb::object T_frame_table, double half_width, double tilt_sigma,
                            double height_sigma, double edge_sigma, double surface_sigma,
                            double centroid_sigma) {
  check_length("half_width", half_width, 0);
  check_length("tilt_sigma", tilt_sigma, kLeast);
  check_length("height_sigma", height_sigma, kLeast);
  check_length("edge_sigma", edge_sigma, kLeast);
  check_length("surface_sigma", surface_sigma, 0);
  check_length("centroid_sigma", centroid_sigma, 0);
  lo::TableSupport table;
  table.T_frame_table = pose_from(T_frame_table, "T_frame_table");
  table.half_width = half_width;
  table.tilt_sigma = tilt_sigma;
  table.height_sigma = height_sigma;
  table.edge_sigma = edge_sigma;
  table.surface_sigma = surface_sigma;
  table.centroid_sigma = centroid_sigma;
  return table;
}

Posterior localize(nb::object model, const Contacts& contacts, const std::string& method,
                   std::optional<lo::TableSupport> table, nb::object free_space, nb::object planes,
                   const std::optional<PosePrior>& prior, double false_contacts,
                   double noise_scale_prior, double size_prior, double surface_sigma, int proposals,
                   int particles, int modes, std::uint64_t seed) {
  if (method != "fast" && method != "full") {
    throw BadInput(fmt::format("method is '{}', not 'fast' or 'full'", method));
  }
  const SharedModel shared = model_from(model);
  lo::Evidence evidence =
      evidence_from(contacts, {std::move(table), free_space, planes, false_contacts,
                               noise_scale_prior, size_prior, surface_sigma});
  if (prior) {
    require_same_name("prior", prior->object, shared->object().name);
    evidence.prior = prior->prior;
  }
  lo::LocalizerOptions options;
  options.proposals = proposals;
  options.particles = particles;
  options.modes = modes;
  options = checked(options);
  const WithoutGil release;
  const RandomStream random(seed, "localize");
  return {method == "fast" ? lo::localize_fast(*shared, evidence, random, options)
                           : lo::localize(*shared, evidence, random, options),
          shared};
}

PosePrior prior_from(const Posterior& posterior, nb::object motion_covariance,
                     std::optional<double> floor) {
  if (floor && !(*floor > 0 && *floor < 1)) {
    throw BadInput(fmt::format("floor is {}, not between 0 and 1", *floor));
  }
  const bool moved = is_given(motion_covariance);
  lo::PosePrior prior = lo::prior_from(
      posterior.found,
      moved ? covariance_from(motion_covariance, "motion_covariance") : Matrix6d(Matrix6d::Zero()));
  if (floor) prior.floor = *floor;
  return {std::move(prior), posterior.model->object().name};
}

void bind_evidence(nb::module_& module) {
  nb::class_<lo::TableSupport> table(module, "TableSupport",
                                     "The object rests on a table in one of its stable poses.");
  bind_pickle(table);
  table
      .def(
          "__init__",
          [](lo::TableSupport* self, nb::object T, double half_width, double tilt_sigma,
             double height_sigma, double edge_sigma, double surface_sigma, double centroid_sigma) {
            new (self) lo::TableSupport(make_table(T, half_width, tilt_sigma, height_sigma,
                                                   edge_sigma, surface_sigma, centroid_sigma));
          },
          "T_frame_table"_a, nb::kw_only(), "half_width"_a = 0.02, "tilt_sigma"_a = 0.02,
          "height_sigma"_a = 0.001, "edge_sigma"_a = 0.002, "surface_sigma"_a = 0.0,
          "centroid_sigma"_a = 0.0,
          nb::sig(
              "def __init__(self, T_frame_table: numpy.typing.ArrayLike, *, half_width: float "
              "= 0.02, tilt_sigma: float = 0.02, height_sigma: float = 0.001, edge_sigma: "
              "float = 0.002, surface_sigma: float = 0.0, centroid_sigma: float = 0.0) -> None"),
          "Raises ValueError unless T_frame_table is a pose (4, 4), and for numbers that are "
          "negative or of no table.")
      .def_prop_ro(
          "T_frame_table", [](const lo::TableSupport& self) { return pose(self.T_frame_table); },
          nb::sig("def T_frame_table(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(4, 4): z up, z = 0 the surface, x and y the rough place of the object's centroid, m.")
      .def_ro("half_width", &lo::TableSupport::half_width,
              "The centroid is within +- this of that place in x and y, m.")
      .def_ro("tilt_sigma", &lo::TableSupport::tilt_sigma, "Error of the table's tilt, rad.")
      .def_ro("height_sigma", &lo::TableSupport::height_sigma, "Error of its height, m.")
      .def_ro("edge_sigma", &lo::TableSupport::edge_sigma, "Softness of half_width, m.")
      .def_ro("surface_sigma", &lo::TableSupport::surface_sigma,
              "Error of the surface on which the object rests, by which it leans, m.")
      .def_ro("centroid_sigma", &lo::TableSupport::centroid_sigma,
              "Error of the centre of mass per axis, by which the object leans, m.")
      .def("__repr__", [](const lo::TableSupport& self) {
        const Eigen::Vector3d t = self.T_frame_table.translation();
        return fmt::format("TableSupport(({:.3f}, {:.3f}, {:.3f}) m, +- {:.3f} m)", t.x(), t.y(),
                           t.z(), self.half_width);
      });
  nb::class_<PosePrior> prior(module, "PosePrior", "What was known of the pose before.");
  bind_pickle(prior);
  prior.def("__len__", [](const PosePrior& self) { return self.prior.components.size(); })
      .def("__repr__", [](const PosePrior& self) {
        return fmt::format("PosePrior('{}', {} components)", self.object,
                           self.prior.components.size());
      });
  module.def("prior_from", &prior_from, "posterior"_a, "motion_covariance"_a = nb::none(),
             nb::kw_only(), "floor"_a = nb::none(),
             nb::sig("def prior_from(posterior: Posterior, motion_covariance: "
                     "numpy.typing.ArrayLike | None = None, *, floor: float | None = None) -> "
                     "PosePrior"),
             "What an earlier posterior says after a motion known up to a normal error, (6, 6) of "
             "[rotation; translation], rad and m. floor: density that every pose keeps, of the "
             "peak's, so that touch can overrule the prior; by default that of the mass outside "
             "the posterior's 95 % credible set, or 0.05, over all rotations and a cubic "
             "decimetre.\n\nRaises ValueError without modes or for what is no covariance, and "
             "for a floor that is not between 0 and 1.");
}

/// A tracker with the object that its posteriors show.
struct Tracker {
  SharedModel model;
  lo::Tracker filter;
  std::mutex busy = {};
};

void bind_tracker(nb::module_& module) {
  nb::class_<Tracker>(module, "Tracker",
                      "Follows an object that moves with the fingers and may slip in them: an "
                      "iterated extended Kalman filter (Bell & Cathey 1993) for each mode.")
      .def(
          "__init__",
          [](Tracker* self, nb::object model, const Posterior& start, std::uint64_t seed) {
            const SharedModel shared = model_from(model);
            require_same_object(start, *shared);
            new (self) Tracker{
                shared, lo::Tracker(*shared, start.found, {}, RandomStream(seed, "tracker"))};
          },
          "model"_a, "start"_a, nb::kw_only(), "seed"_a = 0,
          nb::sig("def __init__(self, model: ObjectModel, start: Posterior, *, seed: int = 0) -> "
                  "None"),
          "From a posterior with modes.\n\nRaises ValueError for one without, or of another "
          "object.")
      .def(
          "update",
          [](Tracker& self, double time, const Contacts& contacts, nb::object velocities) {
            const lo::TrackFrame frame{time, contacts.list, points_from(velocities, "velocities")};
            const WithoutGil release;
            const std::lock_guard lock(self.busy);
            return Posterior{self.filter.update(frame), self.model};
          },
          "time"_a, "contacts"_a, "velocities"_a,
          nb::sig("def update(self, time: float, contacts: Contacts, velocities: "
                  "numpy.typing.ArrayLike) -> Posterior"),
          "The posterior after what the fingertips sense at a time (s): contacts, and the "
          "fingertip's velocity at each, (N, 3), m/s. A time that is not later than the last one "
          "changes nothing.\n\nRaises ValueError for values that are not finite or another number "
          "of velocities.")
      .def_prop_ro(
          "slips", [](const Tracker& self) { return self.filter.slips(); }, "Found so far.")
      .def("__repr__", [](const Tracker& self) {
        return fmt::format("Tracker('{}', {} slips)", self.model->object().name,
                           self.filter.slips());
      });
}

}  // namespace

void require_same_object(const Posterior& posterior, const geometry::ObjectModel& model) {
  require_same_name("posterior", posterior.model->object().name, model.object().name);
}

void bind_localization(nb::module_& module) {
  bind_posterior(module);
  bind_evidence(module);
  bind_tracker(module);
  module.def(
      "pose_error",
      [](nb::object model, nb::object estimate, nb::object truth) {
        const auto error =
            lo::pose_error(pose_from(estimate, "estimate"), pose_from(truth, "truth"),
                           model_from(std::move(model))->object().symmetries);
        return std::pair{error.rotation, error.translation};
      },
      "model"_a, "estimate"_a, "truth"_a,
      nb::sig("def pose_error(model: ObjectModel, estimate: numpy.typing.ArrayLike, truth: "
              "numpy.typing.ArrayLike) -> tuple[float, float]"),
      "How far a pose (4, 4), T_frame_object, is from the true one, modulo the object's "
      "symmetries: rad, and m of the volume centroid.\n\nRaises ValueError unless both are poses.");
  const lo::Evidence evidence;
  const lo::LocalizerOptions options;
  module.def(
      "localize", &localize, "model"_a, "contacts"_a, nb::kw_only(), "method"_a = "fast",
      "table"_a = nb::none(), "free_space"_a = nb::none(), "planes"_a = nb::none(),
      "prior"_a = nb::none(), "false_contacts"_a = evidence.false_contact_share,
      "noise_scale_prior"_a = evidence.noise_scale_prior, "size_prior"_a = evidence.size_prior,
      "surface_sigma"_a = evidence.surface_sigma, "proposals"_a = options.proposals,
      "particles"_a = options.particles, "modes"_a = options.modes, "seed"_a = 0,
      nb::sig("def localize(model: ObjectModel, contacts: Contacts, *, method: str = 'fast', "
              "table: TableSupport | None = None, free_space: numpy.typing.ArrayLike | None = "
              "None, planes: numpy.typing.ArrayLike | None = None, prior: PosePrior | None = None, "
              "false_contacts: float = 0.02, "
              "noise_scale_prior: float = 0.4, size_prior: float = 0.25, surface_sigma: float = "
              "0.0003, proposals: int = 40000, particles: int = 800, modes: int = 16, seed: int = "
              "0) -> Posterior"),
      "Posterior of the object's pose in the contacts' frame, by tempered sequential Monte Carlo "
      "(Petrovskaya & Khatib 2011; Del Moral, Doucet & Jasra 2006).\n\nmethod 'fast' answers in a "
      "tenth of the time where the contacts settle the pose, "
      "and turns to 'full' elsewhere. free_space (N, 4): x, y, z, radius (m) of balls that are "
      "free of the object. planes (N, 4) or (N, 5): nx, ny, nz, height and sigma (m; 0.001 if left "
      "out) of planes on which the held object was let down until its lowest point touched; the "
      "unit normal points to the object's side, the height is over the origin along it. "
      "false_contacts: prior share of contacts with something else. "
      "noise_scale_prior, size_prior: chance that the noise, or the object's size, is not as "
      "stated. surface_sigma: m by which the mesh is off the surface. Contacts that repeat a touch "
      "count once (docs/localization.md), and of more than 64 so "
      "many are used.\n\nRaises ValueError for values that are not finite, sigmas that are not "
      "positive, contacts spread as if in millimetres, and a prior of another object. That no pose "
      "fits, and that there are no contacts, table or prior, is a status.");
}

}  // namespace palpate::python
