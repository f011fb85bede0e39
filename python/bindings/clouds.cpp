// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "cloud_argument.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/cloud/normals.hpp"
#include "palpate/geometry/io/point_cloud_io.hpp"
#include "palpate/registration/cloud_registration.hpp"
#include "registration_fields.hpp"
#include "registration_words.hpp"
#include "without_gil.hpp"

namespace palpate::python {
namespace {

namespace re = registration;
using namespace nb::literals;
using Cloud = geometry::PointCloud;

Cloud cloud_from(nb::handle points, nb::handle normals) {
  Cloud cloud{points_from(points, "points"), {}};
  if (is_given(normals)) cloud.normals = points_from(normals, "normals");
  geometry::check_cloud(cloud);
  return cloud;
}

/// What both ways to register clouds are given.
struct Common {
  std::optional<double> noise_bound;
  nb::object initial, rotation_axis;
  bool translation_only;
  std::string primitive;
  double max_false_alarms;
  bool best_effort;
  int bound_nodes;
  std::uint64_t seed;
  int threads;

  re::CloudOptions options() const {
    re::CloudOptions options;
    options.noise_bound = noise_bound;
    options.threads = threads;
    re::RegistrationOptions& registration = options.registration;
    if (is_given(initial)) registration.initial = pose_from(initial, "initial");
    if (is_given(rotation_axis)) {
      registration.rotation_axis = vector_from(rotation_axis, "rotation_axis");
    }
    registration.translation_only = translation_only;
    registration.primitive = primitive_of(primitive);
    registration.max_false_alarms = max_false_alarms;
    registration.best_effort = best_effort;
    registration.robust_bound.max_nodes = bound_nodes;
    registration.seed = seed;
    return options;
  }
};

re::CloudRegistration register_clouds(nb::object source, nb::object target,
                                      std::optional<double> noise_bound, double voxel,
                                      nb::object initial, nb::object rotation_axis,
                                      bool translation_only, bool estimate_scale, int instances,
                                      const std::string& primitive, double max_false_alarms,
                                      bool best_effort, int bound_nodes, std::uint64_t seed,
                                      int threads) {
  auto options =
      Common{noise_bound, initial,     rotation_axis, translation_only, primitive, max_false_alarms,
             best_effort, bound_nodes, seed,          threads}
          .options();
  options.features.voxel = voxel;
  options.registration.estimate_scale = estimate_scale;
  options.registration.instances = instances;
  const CloudArgument from(source, "source"), to(target, "target");
  const WithoutGil release;
  return re::register_clouds(from.view(), to.view(), options);
}

re::FeatureCloud described(nb::handle points, nb::handle features, const std::string& what,
                           const re::CloudOptions& options) {
  re::FeatureCloud result;
  result.features = matrix_from(features, what + "_features").transpose().cast<float>();
  for (Eigen::Index i = 0; i < result.features.cols(); ++i) {
    if (result.features.col(i).allFinite()) continue;
    throw BadInput(fmt::format("{}_features: row {} holds what is no finite float32", what, i));
  }
  result.cloud = geometry::copied(CloudArgument(points, what).view());
  geometry::check_cloud(result.cloud);
  if (!result.cloud.has_normals() && result.cloud.size() >= 3) {
    result.cloud = geometry::with_normals(std::move(result.cloud),
                                          options.features.normal_neighbours, options.threads);
  }
  return result;
}

re::CloudRegistration register_described(nb::object source, nb::object source_features,
                                         nb::object target, nb::object target_features,
                                         double voxel, std::optional<double> noise_bound,
                                         nb::object initial, nb::object rotation_axis,
                                         bool translation_only, const std::string& primitive,
                                         double max_false_alarms, bool best_effort, int bound_nodes,
                                         std::uint64_t seed, int threads) {
  const auto options =
      Common{noise_bound, initial,     rotation_axis, translation_only, primitive, max_false_alarms,
             best_effort, bound_nodes, seed,          threads}
          .options();
  const auto from = described(source, source_features, "source", options),
             to = described(target, target_features, "target", options);
  const WithoutGil release;
  return re::register_described(from, to, voxel, options);
}

}  // namespace

void bind_clouds(nb::module_& module) {
  nb::class_<Cloud>(module, "PointCloud", "Points in metres, with or without normals.")
      .def(
          "__init__",
          [](Cloud* self, nb::object points, nb::object normals) {
            new (self) Cloud(cloud_from(points, normals));
          },
          "points"_a, "normals"_a = nb::none(),
          nb::sig("def __init__(self, points: numpy.typing.ArrayLike, normals: "
                  "numpy.typing.ArrayLike | None = None) -> None"),
          "Points (N, 3), m, and unit normals (N, 3).\n\nRaises ValueError, naming the point.")
      .def("__len__", &Cloud::size)
      .def_prop_ro(
          "points", [](const Cloud& self) { return rows(self.points); }, "(N, 3), m.")
      .def_prop_ro(
          "normals",
          [](const Cloud& self) -> std::optional<Rows3> {
            if (!self.has_normals()) return std::nullopt;
            return rows(self.normals);
          },
          "(N, 3), unit; None without.")
      .def("__getstate__",
           [](const Cloud& self) { return std::tuple(rows(self.points), rows(self.normals)); })
      .def("__setstate__",
           [](Cloud* self, const std::tuple<nb::object, nb::object>& state) {
             new (self) Cloud(cloud_from(std::get<0>(state), std::get<1>(state)));
           })
      .def("__repr__", [](const Cloud& self) {
        return fmt::format("PointCloud({} points, {} normals)", self.size(),
                           self.has_normals() ? "with" : "without");
      });
  using Registration = re::CloudRegistration;
  nb::class_<Registration> registration(module, "CloudRegistration",
                                        "Pose of one cloud in another.");
  bind_pickle(registration);
  registration.def_ro("result", &Registration::result, "Its inliers are pairs of nearest points.")
      .def_ro("overlap", &Registration::overlap,
              "Share of the source's points that have a target point within the bound.")
      .def_ro("contradiction", &Registration::contradiction,
              "Share of the surface that lies 1 to 3 bounds off the other cloud's where it should "
              "lie on it; above 0.1 there is no pose, unless best_effort is set.")
      .def_ro("rms_error", &Registration::rms_error, "Of the refined pairs, m.")
      .def_ro("noise_bound", &Registration::noise_bound, "That was used, m.")
      .def_ro("voxel", &Registration::voxel, "That was used, m.")
      .def_ro("feature_matches", &Registration::feature_matches, "Mutual matches of features.")
      .def_ro("feature_inliers", &Registration::feature_inliers,
              "Of these, within the bound before the refinement; certificate.robust speaks of "
              "them.")
      .def_ro("refinements", &Registration::refinements, "Rounds of nearest neighbours.")
      .def_prop_ro(
          "source", [](const Registration& self) { return rows(self.correspondences.source); },
          "Points of the pairs that result.inliers counts, (N, 3), m; of the scaled source.")
      .def_prop_ro(
          "target", [](const Registration& self) { return rows(self.correspondences.target); },
          "Their nearest points, (N, 3), m.")
      .def("__repr__", [](const Registration& self) {
        return fmt::format("CloudRegistration({}, overlap {:.2f}, rms error {:.2f} mm)",
                           re::to_string(self.result.status), self.overlap, 1e3 * self.rms_error);
      });
  module.def("load_cloud", &geometry::load_cloud, "path"_a, nb::kw_only(), "samples"_a = 20000,
             nb::call_guard<WithoutGil>(),
             "Read PLY, PCD, XYZ or OBJ; a mesh is sampled at so many points.\n\nRaises "
             "ValueError, naming file and line.");
  module.def(
      "register_clouds", &register_clouds, "source"_a, "target"_a, nb::kw_only(),
      "noise_bound"_a = nb::none(), "voxel"_a = 0.0, "initial"_a = nb::none(),
      "rotation_axis"_a = nb::none(), "translation_only"_a = false, "estimate_scale"_a = false,
      "instances"_a = 1, "primitive"_a = "plane", "max_false_alarms"_a = 0.01,
      "best_effort"_a = false, "bound_nodes"_a = 0, "seed"_a = 0, "threads"_a = 1,
      nb::sig("def register_clouds(source: PointCloud | numpy.typing.ArrayLike, target: PointCloud "
              "| numpy.typing.ArrayLike, *, noise_bound: "
              "float | None = None, voxel: float = 0.0, initial: numpy.typing.ArrayLike | "
              "None = None, rotation_axis: numpy.typing.ArrayLike | None = None, "
              "translation_only: bool = False, estimate_scale: bool = False, instances: int = "
              "1, primitive: str = 'plane', max_false_alarms: float = 0.01, best_effort: bool = "
              "False, bound_nodes: int = 0, seed: int = 0, threads: int = 1) -> CloudRegistration"),
      "Pose of one cloud in another without given pairs: mutual matches of FPFH (Rusu, "
      "Blodow & Beetz 2009), outliers rejected, then nearest neighbours and pose in turn (thesis "
      "6.1-6.2).\n\nsource, target: "
      "PointCloud, or points (N, 3), m; arrays of float64 and float32 are read in place and "
      "must not change during the call. noise_bound, "
      "voxel: m, chosen by the clouds if not given. initial (4, 4): replaces the "
      "features. rotation_axis (3,): turn about it alone, the same in both frames, as "
      "gravity is. estimate_scale: the target is a scaled source. instances: poses looked "
      "for, each in the points that remain. primitive: 'plane' or 'point', residuals of the "
      "refinement. bound_nodes > 0 also bounds the inliers of any pose, among the matches of "
      "features.\n\nRaises ValueError for clouds or options that cannot "
      "be used.");
  module.def(
      "register_described", &register_described, "source"_a, "source_features"_a, "target"_a,
      "target_features"_a, nb::kw_only(), "voxel"_a, "noise_bound"_a = nb::none(),
      "initial"_a = nb::none(), "rotation_axis"_a = nb::none(), "translation_only"_a = false,
      "primitive"_a = "plane", "max_false_alarms"_a = 0.01, "best_effort"_a = false,
      "bound_nodes"_a = 0, "seed"_a = 0, "threads"_a = 1,
      nb::sig("def register_described(source: PointCloud | numpy.typing.ArrayLike, "
              "source_features: numpy.typing.ArrayLike, target: PointCloud | "
              "numpy.typing.ArrayLike, target_features: "
              "numpy.typing.ArrayLike, *, voxel: float, noise_bound: float | None = None, initial: "
              "numpy.typing.ArrayLike | None = None, "
              "rotation_axis: numpy.typing.ArrayLike | None = None, translation_only: bool = "
              "False, primitive: str = 'plane', max_false_alarms: float = 0.01, best_effort: bool "
              "= False, bound_nodes: int = 0, seed: int = 0, threads: int = 1) -> "
              "CloudRegistration"),
      "register_clouds() by features of any kind, (N, D), one row a point, that are nearest for "
      "like places.\n\nvoxel: distance between the points, m. Mirrored clouds are not "
      "recognised.\n\nRaises ValueError for another number of features than points.");
}

}  // namespace palpate::python
