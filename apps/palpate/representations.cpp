// SPDX-License-Identifier: Apache-2.0
#include "representations.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <optional>
#include <string>

#include "palpate/core/error.hpp"
#include "palpate/geometry/mesh/sampling.hpp"
#include "palpate/simulation/world/convex_parts.hpp"
#include "simulation/contact/exact_contact.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::app {
namespace {

constexpr double kBallLength = 1e-6;  // m, of the capsule that stands for a ball
constexpr double kFlexRadius = 1e-5;  // m, by which a flex is thicker than its triangles
constexpr double kNearest = 2e-6;     // m, by which another place of the surface may be nearer
constexpr int kDraws = 4;             // places tried a ball: others do not have room in a hollow

std::string numbers(const std::vector<Eigen::Vector3d>& points) {
  std::string text;
  for (const Eigen::Vector3d& p : points) {
    text += fmt::format("{:.9g} {:.9g} {:.9g} ", p.x(), p.y(), p.z());
  }
  return text;
}

std::string numbers(const std::vector<std::array<int, 3>>& triangles) {
  std::string text;
  for (const auto& t : triangles) text += fmt::format("{} ", fmt::join(t, " "));
  return text;
}

std::string mesh_asset(int number, const geometry::TriangleMesh& mesh) {
  return fmt::format(R"(<mesh name="m{}" inertia="shell" vertex="{}" face="{}"/>)", number,
                     numbers(mesh.vertices), numbers(mesh.triangles));
}

struct ObjectXml {
  std::string assets, geoms;
};

ObjectXml describe(Representation representation, const geometry::TriangleMesh& mesh) {
  ObjectXml xml;
  if (representation == Representation::flex) {
    xml.geoms = fmt::format(
        R"(<flexcomp name="b" type="direct" dim="2" rigid="true" radius="{}" mass="0.1" point="{}" element="{}"><contact selfcollide="none"/></flexcomp>)",
        kFlexRadius, numbers(mesh.vertices), numbers(mesh.triangles));
    return xml;
  }
  const auto meshes = representation == Representation::parts
                          ? simulation::convex_parts(mesh)
                          : std::vector<geometry::TriangleMesh>{mesh};
  const std::string type = representation == Representation::sdf ? "sdf" : "mesh";
  for (int i = 0; i < static_cast<int>(meshes.size()); ++i) {
    xml.assets += mesh_asset(i, meshes[static_cast<std::size_t>(i)]);
    xml.geoms += fmt::format(R"(<geom name="g{}" type="{}" mesh="m{}"/>)", i, type, i);
  }
  return xml;
}

simulation::ModelHandle make_model(Representation representation,
                                   const geometry::TriangleMesh& mesh, double radius) {
  const ObjectXml object = describe(representation, mesh);
  const std::string tip =
      representation == Representation::exact
          ? fmt::format(R"(type="capsule" size="{} {}")", radius, 0.5 * kBallLength)
          : fmt::format(R"(type="sphere" size="{}")", radius);
  const std::string xml = fmt::format(
      R"(<mujoco><size nuser_geom="{}"/><asset>{}</asset><worldbody><body name="object">{}</body>)"
      R"(<body><freejoint/><geom name="tip" {}/></body></worldbody></mujoco>)",
      simulation::kExactContactUserData, object.assets, object.geoms, tip);
  std::array<char, 512> message{};
  simulation::SpecHandle spec(
      mj_parseXMLString(xml.c_str(), nullptr, message.data(), message.size()));
  if (!spec) throw BadInput(fmt::format("the simulator refuses the mesh: {}", message.data()));
  return simulation::compile(*spec);
}

/// The deepest contact of the tip: its point on the object and the object's outward normal.
struct Found {
  Eigen::Vector3d point, normal;
  double depth = -std::numeric_limits<double>::infinity();
};

std::optional<Found> deepest(const mjData& data, int tip) {
  std::optional<Found> best;
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (best && -contact.dist <= best->depth) continue;
    const double sign = contact.geom[1] == tip ? 1 : -1;
    const Eigen::Vector3d n = sign * simulation::vector3(contact.frame);
    best = Found{simulation::vector3(contact.pos) - 0.5 * contact.dist * n, n, -contact.dist};
  }
  return best;
}

double cpu_seconds_since(std::clock_t start) {
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

double angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

std::string_view to_string(Representation representation) {
  switch (representation) {
    case Representation::hull:
      return "hull";
    case Representation::parts:
      return "parts";
    case Representation::sdf:
      return "sdf";
    case Representation::flex:
      return "flex";
    case Representation::exact:
      return "exact";
  }
  return "";
}

std::vector<TestSphere> place_test_spheres(const geometry::MeshQuery& mesh, int count,
                                           double radius, double depth, RandomStream random) {
  if (count < 1 || !(depth > 0 && depth < radius)) {
    throw BadInput(
        fmt::format("probes need a count of 1 or more and 0 < depth < radius, not {}, "
                    "{} m and {} m",
                    count, depth, radius));
  }
  std::vector<TestSphere> probes;
  const auto draws = static_cast<std::size_t>(kDraws * count);
  for (const geometry::SurfaceSample& sample :
       geometry::sample_surface(mesh.mesh(), draws, random)) {
    const Eigen::Vector3d center = sample.point + (radius - depth) * sample.normal;
    const geometry::ClosestPoint touch = mesh.closest_point(center);
    // A ball that something else touches deeper, or whose middle lies inside, is none.
    if (touch.distance < radius - depth - kNearest || mesh.inside(center)) continue;
    probes.push_back({center, touch});
  }
  const auto wanted = static_cast<std::size_t>(count);
  if (probes.size() < wanted) {
    throw BadInput(fmt::format("the surface has room for only {} of {} balls of {} m",
                               probes.size(), draws, radius));
  }
  for (std::size_t i = 0; i < wanted; ++i) probes[i] = probes[i * probes.size() / wanted];
  probes.resize(wanted);
  return probes;
}

RepresentationResult measure_representation(Representation representation,
                                            const geometry::MeshQuery& mesh,
                                            const std::vector<TestSphere>& probes, double radius) {
  if (probes.empty()) throw BadInput("a representation is measured with one probe or more");
  RepresentationResult result;
  const std::clock_t start = std::clock();
  const geometry::CapsuleCollider collider(mesh);
  const simulation::ModelHandle model = make_model(representation, mesh.mesh(), radius);
  if (representation == Representation::exact) {
    simulation::use_exact_surface(*model, simulation::find_id(*model, mjOBJ_GEOM, "g0"), collider);
  }
  result.prepare_seconds = cpu_seconds_since(start);
  const simulation::DataHandle data(mj_makeData(model.get()));
  const auto place = [&](const TestSphere& probe) {
    mjtNum* const position = data->qpos + model->nq - 7;  // of the ball's free joint, the last one
    Eigen::Vector3d::Map(position) = probe.center;
    Eigen::Vector4d::Map(position + 3) << 1, 0, 0, 0;
    mj_fwdPosition(model.get(), data.get());
  };
  const std::clock_t before = std::clock();
  for (const TestSphere& probe : probes) place(probe);
  result.call_seconds = cpu_seconds_since(before) / static_cast<double>(probes.size());
  const int tip = simulation::find_id(*model, mjOBJ_GEOM, "tip");
  for (const TestSphere& probe : probes) {
    place(probe);
    const auto found = deepest(*data, tip);
    if (!found) {
      ++result.missed;
      continue;
    }
    const Eigen::Vector3d normal = (probe.center - probe.touch.point).normalized();
    result.angles.push_back(angle(found->normal, normal));
    result.offsets.push_back((found->point - probe.touch.point).norm());
    result.depths.push_back(found->depth);
  }
  return result;
}

}  // namespace palpate::app
