// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "arrays.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "pickle.hpp"
#include "without_gil.hpp"

namespace palpate::python {
namespace {

namespace ge = geometry;
using namespace nb::literals;

ge::TriangleMesh triangles_from(nb::handle vertices, nb::handle triangles) {
  ge::TriangleMesh mesh;
  mesh.vertices = points_from(vertices, "vertices");
  const auto count = static_cast<double>(mesh.vertices.size());
  for (const Eigen::Vector3d& t : points_from(triangles, "triangles")) {
    const bool whole = t.allFinite() && t == t.array().floor().matrix();
    if (!(whole && t.minCoeff() >= 0 && t.maxCoeff() < count)) {
      throw BadInput(fmt::format("triangle {} names vertices {}, {}, {} of {}",
                                 mesh.triangles.size(), t[0], t[1], t[2], mesh.vertices.size()));
    }
    mesh.triangles.push_back(
        {static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2])});
  }
  return mesh;
}

Triangles triangles_of(const ge::TriangleMesh& mesh) {
  const auto& list = mesh.triangles;
  Triangles result(static_cast<Eigen::Index>(list.size()), 3);
  for (std::size_t i = 0; i < list.size(); ++i) {
    result.row(static_cast<Eigen::Index>(i)) << list[i][0], list[i][1], list[i][2];
  }
  return result;
}

}  // namespace

template <>
struct Kept<geometry::TriangleMesh> {
  static nb::object of(const geometry::TriangleMesh& mesh) {
    return nb::make_tuple(rows(mesh.vertices), triangles_of(mesh));
  }
  static void into(nb::handle kept, geometry::TriangleMesh& mesh) {
    const auto [vertices, triangles] = nb::cast<std::tuple<nb::object, nb::object>>(kept);
    mesh = triangles_from(vertices, triangles);
  }
};
template <>
struct Fields<geometry::MassProperties> {
  static auto of(geometry::MassProperties& it) {
    return std::tie(it.volume, it.centroid, it.inertia);
  }
};
template <>
struct Fields<geometry::StablePose> {
  static auto of(geometry::StablePose& it) {
    return std::tie(it.R_table_object, it.height, it.probability);
  }
};
template <>
struct Fields<geometry::KnownObject> {
  static auto of(geometry::KnownObject& it) {
    return std::tie(it.name, it.mesh, it.T_mesh_object, it.mass, it.mass_properties,
                    it.stable_poses, it.symmetries, it.repairs, it.size);
  }
  static void check(const geometry::KnownObject& it) {
    const double longest = geometry::bounds(it.mesh).sizes().maxCoeff();
    if (!it.mesh.triangles.empty() && longest > 0 && longest < kLargest) return;
    throw BadInput(fmt::format("the object '{}' is {} m long, of {} triangles", it.name, longest,
                               it.mesh.triangles.size()));
  }

 private:
  static constexpr double kLargest = 1;  // m; load_known_object() allows less
};

namespace {

constexpr double kLeastFactor = 0.1;  // of a size

Mesh mesh_of(ge::TriangleMesh triangles) {
  return {std::make_shared<const ge::MeshQuery>(std::move(triangles))};
}

/// @throws BadInput for a name that says another format
void save(const ge::TriangleMesh& mesh, const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (!ending.empty() && ending != ".ply") {
    throw BadInput(fmt::format("'{}': a mesh is saved as PLY, not as '{}'", path.string(), ending));
  }
  ge::save_ply(path, mesh);
}

struct ClosestPoints {
  Rows3 points, normals;
  Eigen::VectorXd distances;
};

}  // namespace

template <>
struct Fields<ClosestPoints> {
  static auto of(ClosestPoints& it) { return std::tie(it.points, it.normals, it.distances); }
};

namespace {

ClosestPoints closest_points(const Mesh& mesh, nb::handle at) {
  const auto asked = points_from(at, "points");
  const WithoutGil release;
  const auto count = static_cast<Eigen::Index>(asked.size());
  ClosestPoints result{Rows3(count, 3), Rows3(count, 3), Eigen::VectorXd(count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const ge::ClosestPoint nearest = mesh.query->closest_point(asked[static_cast<std::size_t>(i)]);
    result.points.row(i) = nearest.point.transpose();
    result.normals.row(i) = nearest.normal.transpose();
    result.distances[i] = nearest.distance;
  }
  return result;
}

Eigen::VectorXd signed_distance(const Mesh& mesh, nb::handle at) {
  const auto asked = points_from(at, "points");
  const WithoutGil release;
  Eigen::VectorXd result(static_cast<Eigen::Index>(asked.size()));
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    result[i] = mesh.query->signed_distance(asked[static_cast<std::size_t>(i)]);
  }
  return result;
}

void bind_mesh(nb::module_& module) {
  nb::class_<ClosestPoints> closest(module, "ClosestPoints",
                                    "Closest points of a surface, one a query.");
  bind_pickle(closest);
  closest
      .def_ro("points", &ClosestPoints::points, nb::rv_policy::copy, "On the surface, (N, 3), m.")
      .def_ro("normals", &ClosestPoints::normals, nb::rv_policy::copy,
              "Outward pseudonormals of the face, edge or vertex, (N, 3), unit.")
      .def_ro("distances", &ClosestPoints::distances, nb::rv_policy::copy, "(N,), m, >= 0.")
      .def("__repr__", [](const ClosestPoints& self) {
        return fmt::format("ClosestPoints({} points)", self.distances.size());
      });
  nb::class_<Mesh>(module, "Mesh",
                   "Triangle mesh in metres; triangles wind counter-clockwise seen from outside.")
      .def(
          "__init__",
          [](Mesh* self, nb::object vertices, nb::object triangles) {
            new (self) Mesh(mesh_of(triangles_from(vertices, triangles)));
          },
          "vertices"_a, "triangles"_a,
          nb::sig("def __init__(self, vertices: numpy.typing.ArrayLike, triangles: "
                  "numpy.typing.ArrayLike) -> None"),
          "A mesh of vertices (V, 3), m, and triangles (T, 3), indices.\n\nRaises ValueError for "
          "an index that names no vertex, and for no triangles.")
      .def_prop_ro(
          "vertices", [](const Mesh& self) { return rows(self.triangles().vertices); },
          "(V, 3), m.")
      .def_prop_ro(
          "triangles", [](const Mesh& self) { return triangles_of(self.triangles()); },
          "(T, 3), indices of vertices.")
      .def_prop_ro(
          "area", [](const Mesh& self) { return ge::area(self.triangles()); }, "Surface area, m^2.")
      .def("closest_points", &closest_points, "points"_a,
           nb::sig("def closest_points(self, points: numpy.typing.ArrayLike) -> ClosestPoints"),
           "The nearest surface point to each of points (N, 3), m.\n\nRaises ValueError for "
           "another shape and for values that are not finite.")
      .def("signed_distance", &signed_distance, "points"_a,
           nb::sig("def signed_distance(self, points: numpy.typing.ArrayLike) -> "
                   "numpy.typing.NDArray[numpy.float64]"),
           "Distance of each of points (N, 3) to the surface, (N,), m, negative inside. The mesh "
           "is watertight.\n\nRaises ValueError for another shape.")
      .def(
          "save",
          [](const Mesh& self, const std::filesystem::path& path) { save(self.triangles(), path); },
          "path"_a,
          "Write a binary PLY in full precision, atomically.\n\nRaises ValueError for a path that "
          "ends as files of another format do.")
      .def("__getstate__",
           [](const Mesh& self) { return Kept<ge::TriangleMesh>::of(self.triangles()); })
      .def("__setstate__",
           [](Mesh* self, nb::object state) {
             new (self) Mesh(mesh_of(restored<ge::TriangleMesh>(state)));
           })
      .def("__repr__", [](const Mesh& self) {
        const Eigen::Vector3d size = 1e3 * ge::bounds(self.triangles()).sizes();
        return fmt::format("Mesh({} vertices, {} triangles, {:.0f} x {:.0f} x {:.0f} mm)",
                           self.triangles().vertices.size(), self.triangles().triangles.size(),
                           size.x(), size.y(), size.z());
      });
  module.def(
      "load_mesh", [](const std::filesystem::path& path) { return mesh_of(ge::load_mesh(path)); },
      "path"_a, nb::call_guard<WithoutGil>(),
      "Read PLY, STL or OBJ in the file's own units.\n\nRaises ValueError, naming the file "
      "and the offending line or element.");
}

void bind_stable_pose(nb::module_& module) {
  nb::class_<ge::StablePose> bound(
      module, "StablePose", "A way the object rests on a plane, with its share of random drops.");
  bind_pickle(bound);
  bound
      .def_prop_ro(
          "R_table_object",
          [](const ge::StablePose& self) { return Rotation3(self.R_table_object); },
          "Rotation up to yaw, (3, 3).")
      .def_ro("height", &ge::StablePose::height, "z of the volume centroid above the table, m.")
      .def_ro("probability", &ge::StablePose::probability,
              "Of a random drop (Goldberg et al. 1999); all sum to 1.")
      .def("__repr__", [](const ge::StablePose& self) {
        return fmt::format("StablePose(probability {:.3f}, height {:.1f} mm)", self.probability,
                           1e3 * self.height);
      });
}

std::string counted(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// The identity, which is always there, is no symmetry to speak of.
std::string symmetry_words(std::size_t rotations) {
  return rotations > 1 ? counted(rotations, "symmetric orientation") : "no symmetry";
}

void bind_object(nb::module_& module) {
  using Object = ge::KnownObject;
  nb::class_<Object> bound(module, "KnownObject",
                           "An object of known shape. Its frame is that of its mesh, moved so that "
                           "the volume centroid is the origin.");
  bind_pickle(bound);
  bound.def_ro("name", &Object::name, "As it was asked for.")
      .def_prop_ro(
          "mesh", [](const Object& self) { return mesh_of(self.mesh); },
          "Watertight, in the object's frame. A new one each time, with the tree that its queries "
          "need: keep it for many of them.")
      .def_ro("mass", &Object::mass, "kg.")
      .def_prop_ro(
          "volume", [](const Object& self) { return self.mass_properties.volume; }, "m^3.")
      .def_prop_ro(
          "T_mesh_object", [](const Object& self) { return pose(self.T_mesh_object); },
          "Maps the object's frame back to the file's own coordinates, (4, 4).")
      .def_prop_ro(
          "symmetries",
          [](const Object& self) {
            std::vector<Rotation3> result(self.symmetries.begin(), self.symmetries.end());
            return result;
          },
          "Rotations (3, 3) that keep the shape, identity first.")
      .def_ro("stable_poses", &Object::stable_poses, "On a table, most probable first.")
      .def_ro("repairs", &Object::repairs, "What was done to the file's mesh, in words.")
      .def_ro("size", &Object::size, "Relative to the mesh that it was made of.")
      .def(
          "resized",
          [](const Object& self, double factor) {
            return ge::resized(self, plausible(factor, kLeastFactor, 1 / kLeastFactor, "factor"));
          },
          "factor"_a, nb::call_guard<WithoutGil>(),
          "The same shape in another size: lengths times factor, the mass times its cube.\n\n"
          "Raises ValueError for a factor that is not 0.1 to 10, and as load_known_object.")
      .def("__repr__", [](const Object& self) {
        const Eigen::Vector3d size = 1e3 * ge::bounds(self.mesh).sizes();
        return fmt::format("KnownObject('{}', {:.0f} x {:.0f} x {:.0f} mm, {:.3f} kg, {}, {})",
                           self.name, size.x(), size.y(), size.z(), self.mass,
                           symmetry_words(self.symmetries.size()),
                           counted(self.stable_poses.size(), "stable pose"));
      });
  module.def("built_in_objects", &ge::built_in_objects, "Names of the built-in objects.");
  module.def(
      "load_known_object",
      [](const std::filesystem::path& name) { return ge::load_known_object(name.string()); },
      "name_or_file"_a, nb::call_guard<WithoutGil>(),
      "A built-in object, 'generated:SEED', or a mesh file in metres.\n\nRaises ValueError "
      "for an unknown name, or a mesh that cannot be read, repaired, or that is smaller than "
      "10 mm or larger than 400 mm.");
  module.def(
      "make_known_object",
      [](const std::string& name, const Mesh& mesh, double mass) {
        plausible(mass, 0, kMaxMass, "mass in kg");
        return ge::make_known_object(name, mesh.triangles(), mass);
      },
      "name"_a, "mesh"_a, nb::kw_only(), "mass"_a = 0.0, nb::call_guard<WithoutGil>(),
      "An object of that shape; mass in kg, 0: from the volume.\n\nRaises ValueError as "
      "load_known_object, naming the object.");
}

}  // namespace

void bind_geometry(nb::module_& module) {
  bind_mesh(module);
  bind_stable_pose(module);
  bind_object(module);
  nb::class_<ge::ObjectModel>(module, "ObjectModel",
                              "An object prepared for localization: distance field and surface "
                              "samples. Threads may share it.")
      .def(nb::init<ge::KnownObject>(), "object"_a, nb::call_guard<WithoutGil>(),
           "Prepare an object, which takes some tenths of a second.")
      .def_prop_ro(
          "object", [](const ge::ObjectModel& self) { return self.object(); }, "What was prepared.")
      .def_prop_ro("area", &ge::ObjectModel::area, "Of the surface, m^2.")
      .def(
          "__getstate__",
          [](const ge::ObjectModel& self) { return Kept<ge::KnownObject>::of(self.object()); },
          nb::sig("def __getstate__(self) -> tuple"))  // `object` is a property of this class
      .def(
          "__setstate__",
          [](ge::ObjectModel* self, nb::object state) {
            auto object = restored<ge::KnownObject>(state);
            const WithoutGil release;
            new (self) ge::ObjectModel(std::move(object));
          },
          nb::sig("def __setstate__(self, state: tuple, /) -> None"))
      .def("__repr__", [](const ge::ObjectModel& self) {
        return fmt::format("ObjectModel('{}')", self.object().name);
      });
}

}  // namespace palpate::python
