// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "libraries.hpp"
#include "palpate/registration/cloud_registration.hpp"
#include "registration_fields.hpp"
#include "registration_words.hpp"
#include "without_gil.hpp"

namespace palpate::python {
namespace {

namespace re = registration;
using namespace nb::literals;
using Result = re::RegistrationResult;

std::optional<Pose4> pose_of(const Result& result) {
  if (!result.T_target_source) return std::nullopt;
  return pose(*result.T_target_source);
}

std::string repr(const Result& result) {
  if (!result.T_target_source) {
    return fmt::format("RegistrationResult({}, {} inliers)", re::to_string(result.status),
                       result.inliers.size());
  }
  return fmt::format("RegistrationResult({}, {} inliers, {:.1g} false alarms, {:.1f} ms)",
                     re::to_string(result.status), result.inliers.size(), result.false_alarms,
                     1e3 * result.seconds);
}

re::Correspondences pairs_from(nb::handle source, nb::handle target, nb::handle source_normals,
                               nb::handle target_normals, nb::handle weights) {
  re::Correspondences pairs;
  pairs.source = points_from(source, "source");
  pairs.target = points_from(target, "target");
  if (is_given(source_normals))
    pairs.source_normals = points_from(source_normals, "source_normals");
  if (is_given(target_normals))
    pairs.target_normals = points_from(target_normals, "target_normals");
  if (is_given(weights)) pairs.weights = numbers_from(weights, pairs.size(), "weights");
  return pairs;
}

Result register_pairs(nb::object source, nb::object target, nb::object source_normals,
                      nb::object target_normals, nb::object weights, double noise_bound,
                      double normal_noise_deg, const std::string& primitive,
                      double max_false_alarms, bool best_effort, nb::object initial,
                      nb::object rotation_axis, bool translation_only, bool estimate_scale,
                      int instances, int bound_nodes, std::uint64_t seed) {
  const auto pairs = pairs_from(source, target, source_normals, target_normals, weights);
  re::RegistrationOptions options;
  options.noise_bound = noise_bound;
  options.normal_noise_deg = normal_noise_deg;
  options.primitive = primitive_of(primitive);
  options.max_false_alarms = max_false_alarms;
  options.best_effort = best_effort;
  if (is_given(initial)) options.initial = pose_from(initial, "initial");
  if (is_given(rotation_axis)) options.rotation_axis = vector_from(rotation_axis, "rotation_axis");
  options.translation_only = translation_only;
  options.estimate_scale = estimate_scale;
  options.instances = instances;
  options.robust_bound.max_nodes = bound_nodes;
  options.seed = seed;
  const WithoutGil release;
  return re::register_correspondences(pairs, options);
}

re::PoseEstimate certify(nb::object T, nb::object source, nb::object target,
                         nb::object source_normals, nb::object target_normals, nb::object weights,
                         const std::string& primitive) {
  const Eigen::Isometry3d T_target_source = pose_from(T, "T_target_source");
  const auto pairs = pairs_from(source, target, source_normals, target_normals, weights);
  const re::Primitive residuals = primitive_of(primitive);
  const WithoutGil release;
  return re::certify(T_target_source, pairs, pairs.weights, residuals);
}

void bind_result(nb::module_& module) {
  nb::class_<re::RobustBound> bound(module, "RobustBound", "What no rigid motion can exceed.");
  bind_pickle(bound);
  bound.def_ro("max_inliers", &re::RobustBound::max_inliers, "No pose has more inliers.")
      .def_ro("min_cost", &re::RobustBound::min_cost,
              "No pose has a smaller truncated cost, m^2: the sum over all pairs of the squared "
              "residual, at most the squared bound.")
      .def_ro("cost", &re::RobustBound::cost, "Truncated cost of the answer, m^2.")
      .def_ro("is_exhausted", &re::RobustBound::is_exhausted, "Branch and bound ran to its end.")
      .def_ro("seconds", &re::RobustBound::seconds, "s.")
      .def("__repr__", [](const re::RobustBound& self) {
        return fmt::format("RobustBound(max_inliers {}, {})", self.max_inliers,
                           self.is_exhausted ? "exhausted" : "stopped");
      });
  using Certificate = re::RegistrationCertificate;
  nb::class_<Certificate> certificate(
      module, "RegistrationCertificate",
      "What is proven of an answer; that there is one is what false_alarms says.");
  bind_pickle(certificate);
  certificate
      .def_ro("least_squares", &Certificate::least_squares,
              "No pose has a smaller sum of squared residuals over the chosen inliers (thesis eqs "
              "6.24-6.34).")
      .def_ro("resolution_deg", &Certificate::resolution_deg,
              "A better pose for these inliers, nearby, is within this angle.")
      .def_ro("robust_bound", &Certificate::robust,
              "A bound on the inliers of any pose (Bustos & Chin 2018); None if not asked for.")
      .def("__repr__", [](const Certificate& self) {
        return fmt::format("RegistrationCertificate(least_squares {}, {})", self.least_squares,
                           self.robust ? fmt::format("at most {} inliers", self.robust->max_inliers)
                                       : "no robust bound");
      });
  nb::class_<re::RunnerUp> runner_up(module, "RunnerUp",
                                     "Another pose that many pairs agree with.");
  bind_pickle(runner_up);
  runner_up.def_ro("inliers", &re::RunnerUp::inliers, "Pairs that agree with it.")
      .def_prop_ro(
          "T_target_source", [](const re::RunnerUp& self) { return pose(self.T_target_source); },
          "(4, 4).")
      .def_ro("false_alarms", &re::RunnerUp::false_alarms, "As of the answer.")
      .def("__repr__", [](const re::RunnerUp& self) {
        return fmt::format("RunnerUp({} inliers)", self.inliers);
      });
  using Motion = re::FreeMotion;
  nb::class_<Motion> motion(module, "FreeMotion",
                            "A motion of the source that changes no residual.");
  bind_pickle(motion);
  motion
      .def_prop_ro(
          "kind", [](const Motion& self) { return std::string(re::to_string(self.kind)); },
          "'rotation', 'translation', 'screw' or 'scaling'.")
      .def_ro("direction", &Motion::direction, nb::rv_policy::copy, "(3,), unit, target frame.")
      .def_ro("point", &Motion::point, nb::rv_policy::copy, "(3,), on the axis, m.")
      .def_ro("pitch", &Motion::pitch, "Of a screw, m/rad.")
      .def("__repr__", [](const Motion& self) {
        return fmt::format("FreeMotion({})", re::to_string(self.kind));
      });
  nb::class_<Result> result(module, "RegistrationResult",
                            "Pose of source in target, with what is known of its quality.");
  bind_pickle(result);
  result
      .def_prop_ro(
          "status", [](const Result& self) { return std::string(re::to_string(self.status)); },
          "'found', 'no_consensus' or 'degenerate'.")
      .def_prop_ro("T_target_source", &pose_of, "(4, 4); None unless found.")
      .def_ro("scale", &Result::scale, "The target is T_target_source of scale times the source.")
      .def_ro("inliers", &Result::inliers, "Indices of pairs, ascending.")
      .def_ro("weights", &Result::weights, "One a pair, 0..1.")
      .def_ro("residuals", &Result::residuals, "Distances of points at the pose, m.")
      .def_ro("cost", &Result::cost, "Sum of squared residuals of the inliers, m^2.")
      .def_ro("bound", &Result::bound, "cost less the least cost is at most this, m^2.")
      .def_ro("false_alarms", &Result::false_alarms,
              "Expected poses as good as this among wrong pairs alone (a contrario).")
      .def_ro("certificate", &Result::certificate, "What is proven.")
      .def_ro("runner_up", &Result::runner_up, "Largest other consensus that came up, or None.")
      .def_ro("instances", &Result::instances, "Further poses, largest first, if asked for.")
      .def_ro("free_motions", &Result::free_motions, "Of 'degenerate'.")
      .def_ro("false_inliers", &Result::false_inliers,
              "Wrong pairs to be expected among the inliers.")
      .def_ro("mirrored", &Result::mirrored,
              "More pairs agree with a mirror image: the answer is refused.")
      .def_prop_ro(
          "covariance", [](const Result& self) { return Covariance6(self.covariance); },
          "Of [rotation; translation] in the target frame, (6, 6), rad and m.")
      .def_ro("seconds", &Result::seconds, "s.")
      .def("__repr__", &repr)
      .def("_repr_html_",
           [](const Result& self) { return fmt::format("<code>{}</code>", repr(self)); });
  using Estimate = re::PoseEstimate;
  nb::class_<Estimate> estimate(module, "PoseEstimate",
                                "What is proven of a pose for given pairs.");
  bind_pickle(estimate);
  estimate
      .def_prop_ro(
          "status", [](const Estimate& self) { return std::string(re::to_string(self.status)); },
          "'certified', 'uncertified' or 'degenerate'.")
      .def_prop_ro(
          "T_target_source", [](const Estimate& self) { return pose(self.T_target_source); },
          "(4, 4).")
      .def_ro("cost", &Estimate::cost, "Sum of weighted squared residuals, m^2.")
      .def_ro("bound", &Estimate::bound, "cost less the least cost is at most this, m^2.")
      .def_ro("rank", &Estimate::rank, "Of the information matrix, 0..6.")
      .def("__repr__", [](const Estimate& self) {
        return fmt::format("PoseEstimate({}, cost {:.3g} m^2, at most {:.3g} m^2 above the least)",
                           re::to_string(self.status), self.cost, self.bound);
      });
}

}  // namespace

void bind_registration(nb::module_& module) {
  bind_result(module);
  module.def(
      "register_correspondences", &register_pairs, "source"_a, "target"_a, nb::kw_only(),
      "source_normals"_a = nb::none(), "target_normals"_a = nb::none(), "weights"_a = nb::none(),
      "noise_bound"_a = 0.004, "normal_noise_deg"_a = 0.0, "primitive"_a = "point",
      "max_false_alarms"_a = 0.01, "best_effort"_a = false, "initial"_a = nb::none(),
      "rotation_axis"_a = nb::none(), "translation_only"_a = false, "estimate_scale"_a = false,
      "instances"_a = 1, "bound_nodes"_a = 0, "seed"_a = 0,
      nb::sig("def register_correspondences(source: numpy.typing.ArrayLike, target: "
              "numpy.typing.ArrayLike, *, source_normals: numpy.typing.ArrayLike | None = None, "
              "target_normals: numpy.typing.ArrayLike | None = None, weights: "
              "numpy.typing.ArrayLike | None = None, noise_bound: float = 0.004, normal_noise_deg: "
              "float = 0.0, primitive: str = 'point', max_false_alarms: float = 0.01, best_effort: "
              "bool = False, initial: "
              "numpy.typing.ArrayLike | None = None, rotation_axis: numpy.typing.ArrayLike | None "
              "= None, translation_only: bool = False, estimate_scale: bool = False, instances: "
              "int = 1, bound_nodes: int = 0, seed: int = 0) -> RegistrationResult"),
      "Pose of source in target from pairs most of which may be wrong.\n\nsource, target (N, 3), "
      "m. noise_bound: largest position error of an inlier, m. primitive: 'point' or 'plane', "
      "residuals of the final solve. bound_nodes > 0 also bounds the inliers of any pose. The pose "
      "is that of the largest consensus; false_alarms says whether "
      "chance explains it (thesis 6.2).\n\nRaises ValueError, naming the pair.");
  module.def("certify", &certify, "T_target_source"_a, "source"_a, "target"_a, nb::kw_only(),
             "source_normals"_a = nb::none(), "target_normals"_a = nb::none(),
             "weights"_a = nb::none(), "primitive"_a = "point",
             nb::sig("def certify(T_target_source: numpy.typing.ArrayLike, source: "
                     "numpy.typing.ArrayLike, target: numpy.typing.ArrayLike, *, source_normals: "
                     "numpy.typing.ArrayLike | None = None, target_normals: "
                     "numpy.typing.ArrayLike | None = None, weights: numpy.typing.ArrayLike | None "
                     "= None, primitive: str = 'point') -> PoseEstimate"),
             "Bound on how far the cost of any given pose (4, 4) of pairs (N, 3), m, is above the "
             "global optimum (Briales & Gonzalez-Jimenez 2017). primitive: 'point', or "
             "'plane' with normals.\n\nRaises ValueError unless the pose is rigid to 1e-6.");
}

}  // namespace palpate::python
