// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings/arrays.hpp"
#include "bindings/pickle.hpp"
#include "bindings/without_gil.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/planning/planner.hpp"
#include "palpate/simulation/collision/collision_scene.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::python {
namespace {

namespace pl = planning;
using namespace nb::literals;

/// A motion, a row a sample: mount x, y, z (m), yaw, pitch, roll (rad), then the actuators (rad).
struct Plan {
  pl::PlanStatus status = pl::PlanStatus::ok;
  std::vector<std::pair<std::size_t, std::string>> faults;
  std::size_t unreachable = 0;
  Matrix samples, corners;
  std::vector<std::size_t> arrivals;
  int checks = 0;
  double seconds = 0;
};

}  // namespace

template <>
struct Fields<Plan> {
  static auto of(Plan& it) {
    return std::tie(it.status, it.faults, it.unreachable, it.samples, it.corners, it.arrivals,
                    it.checks, it.seconds);
  }
  static void check(const Plan& it) {
    constexpr Eigen::Index kMost = pl::kMountCoordinates + hand::kMaxJoints;
    const Eigen::Index width = it.samples.cols();
    if (it.samples.rows() == 0 || (width >= pl::kMountCoordinates && width <= kMost)) return;
    throw BadInput(
        fmt::format("samples of {} values, not {} to {}", width, +pl::kMountCoordinates, kMost));
  }
};

namespace {

/// What a hand may collide with, as it is believed to be. Threads take turns with it.
struct Scene {
  simulation::CollisionScene checker;
  std::string object;  ///< its name; empty: none
  std::mutex busy = {};
};

hand::Description hand_from(nb::handle hand) {
  hand::Description* described = nullptr;
  if (nb::try_cast(hand, described) && described) return *described;
  std::filesystem::path name;
  if (!nb::try_cast(hand, name)) {
    throw nb::type_error(fmt::format("hand is {}, not a name, a file or a palpate.HandDescription",
                                     nb::repr(hand).c_str())
                             .c_str());
  }
  const WithoutGil release;
  return simulation::load_hand(name.string());
}

void make_scene(Scene* self, nb::object hand, nb::object object, const nb::dict& settings) {
  pl::CollisionOptions options;
  apply_settings(settings, options);
  const hand::Description described = hand_from(hand);
  if (!is_given(object)) {
    new (self) Scene{simulation::CollisionScene(described, options), {}};
    return;
  }
  const SharedModel model = object_from(std::move(object));
  new (self)
      Scene{simulation::CollisionScene(model->object(), described, options), model->object().name};
}

pl::Waypoint waypoint_from(const Eigen::VectorXd& row) {
  pl::Waypoint waypoint;
  waypoint.mount = {row.head<3>(), row.segment<3>(3)};
  waypoint.joints = row.tail(row.size() - pl::kMountCoordinates);
  return waypoint;
}

/// (N, 6 + J). @throws BadInput for another width
std::vector<pl::Waypoint> waypoints_from(nb::handle values, const Scene& scene) {
  const Matrix rows = matrix_from(values, "waypoints");
  const Eigen::Index width = pl::kMountCoordinates + scene.checker.hand().joint_count();
  if (rows.cols() != width) {
    throw BadInput(
        fmt::format("waypoints has shape ({}, {}), not (N, {}): x, y, z, yaw, pitch, roll and the "
                    "joints of '{}'",
                    rows.rows(), rows.cols(), width, scene.checker.hand().name));
  }
  std::vector<pl::Waypoint> waypoints;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    waypoints.push_back(waypoint_from(rows.row(i).transpose()));
  }
  return waypoints;
}

pl::Waypoint one_waypoint(nb::handle values, const Scene& scene) {
  const auto numbers = numbers_from(values, "waypoint");
  const auto width =
      static_cast<std::size_t>(pl::kMountCoordinates + scene.checker.hand().joint_count());
  if (numbers.size() != width) {
    throw BadInput(fmt::format("waypoint has {} values, not {}", numbers.size(), width));
  }
  for (std::size_t i = 0; i < width; ++i) {
    if (!std::isfinite(numbers[i])) {
      throw BadInput(fmt::format("waypoint: value {} is {}, not finite", i, numbers[i]));
    }
  }
  return waypoint_from(Eigen::VectorXd::Map(numbers.data(), static_cast<Eigen::Index>(width)));
}

Matrix rows_of(const std::vector<hand::HandCommand>& commands) {
  if (commands.empty()) return {};
  Matrix rows(static_cast<Eigen::Index>(commands.size()),
              pl::coordinates_of(commands.front()).size());
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    rows.row(i) = pl::coordinates_of(commands[static_cast<std::size_t>(i)]).transpose();
  }
  return rows;
}

Plan plan(nb::object waypoints, Scene& scene, std::uint64_t seed, const nb::dict& settings) {
  pl::PlanOptions options;
  apply_settings(settings, options);
  const auto given = waypoints_from(waypoints, scene);
  const WithoutGil release;
  const std::lock_guard lock(scene.busy);
  const pl::Plan found = pl::plan(given, scene.checker, options, seed);
  Plan result{found.status,           {},
              found.unreachable,      rows_of(found.samples),
              rows_of(found.corners), found.arrivals,
              found.checks,           found.seconds};
  for (const pl::InvalidWaypoint& fault : found.invalid)
    result.faults.emplace_back(fault.waypoint, fault.reason);
  return result;
}

std::vector<hand::HandCommand> commands_of(const Plan& plan) {
  std::vector<hand::HandCommand> commands;
  for (Eigen::Index i = 0; i < plan.samples.rows(); ++i) {
    commands.push_back(pl::command_of(pl::Coordinates(plan.samples.row(i).transpose())));
  }
  return commands;
}

double duration(const Plan& plan) {
  return plan.samples.rows() == 0 ? 0 : static_cast<double>(plan.samples.rows() - 1) * hand::kTick;
}

std::optional<std::tuple<std::string, std::string, double>> deepest_collision(Scene& scene,
                                                                              nb::object waypoint) {
  const pl::Waypoint at = one_waypoint(waypoint, scene);
  const WithoutGil release;
  const std::lock_guard lock(scene.busy);
  const auto pair = scene.checker.deepest_collision(at.mount, at.joints);
  if (!pair) return std::nullopt;
  return std::tuple(pair->first, pair->second, pair->depth);
}

void bind_scene(nb::module_& module) {
  nb::class_<Scene>(module, "CollisionScene",
                    "What a motion keeps clear of: the hand itself, a table at height 0, and at "
                    "most one object, as they are believed to be.")
      .def("__init__", &make_scene, "hand"_a = "shadow", "object"_a = nb::none(), nb::kw_only(),
           "options"_a = nb::dict(),
           nb::sig("def __init__(self, hand: str | os.PathLike | palpate._core.HandDescription = "
                   "'shadow', object: str | os.PathLike | palpate._core.ObjectModel | None = None, "
                   "*, options: dict[str, typing.Any] = {}) -> None"),
           "hand: as load_hand() takes it, or a description. object: a name, a mesh file in "
           "metres, or a model; it is far away until it is placed or held. options: "
           "'allowed_depth', m, and 'self'.\n\nRaises ValueError for what there is not, and values "
           "out of their range.")
      .def(
          "place",
          [](Scene& self, nb::object T) {
            const Eigen::Isometry3d pose = pose_from(T, "T_world_object");
            const WithoutGil release;
            const std::lock_guard lock(self.busy);
            self.checker.place(pose);
          },
          "T_world_object"_a,
          nb::sig("def place(self, T_world_object: numpy.typing.ArrayLike) -> None"),
          "Puts the object at rest there, (4, 4); the hand keeps clear of it.\n\nRaises ValueError "
          "for no pose, and without an object.")
      .def(
          "hold",
          [](Scene& self, nb::object T) {
            const Eigen::Isometry3d pose = pose_from(T, "T_palm_object");
            const WithoutGil release;
            const std::lock_guard lock(self.busy);
            self.checker.hold(pose);
          },
          "T_palm_object"_a,
          nb::sig("def hold(self, T_palm_object: numpy.typing.ArrayLike) -> None"),
          "Fixes the object to the palm, (4, 4): the hand may touch it, it keeps clear of the "
          "table.\n\nRaises ValueError for no pose, and without an object.")
      .def(
          "palm_pose",
          [](Scene& self, nb::object waypoint) {
            const pl::Waypoint at = one_waypoint(waypoint, self);
            const WithoutGil release;
            const std::lock_guard lock(self.busy);
            return pose(self.checker.palm_pose(at.mount, at.joints));
          },
          "waypoint"_a,
          nb::sig("def palm_pose(self, waypoint: numpy.typing.ArrayLike) -> "
                  "numpy.typing.NDArray[numpy.float64]"),
          "T_world_palm (4, 4) at (6 + J,), as plan() has waypoints.\n\nRaises ValueError for "
          "another number of values, and for values that are not finite.")
      .def("deepest_collision", &deepest_collision, "waypoint"_a,
           nb::sig("def deepest_collision(self, waypoint: numpy.typing.ArrayLike) -> tuple[str, "
                   "str, float] | None"),
           "The two bodies that overlap deepest at (6 + J,), and by how much, m; None where all is "
           "free.\n\nRaises ValueError for another number of values, and for values that are not "
           "finite.")
      .def("__repr__", [](const Scene& self) {
        return fmt::format("CollisionScene('{}'{})", self.checker.hand().name,
                           self.object.empty() ? "" : fmt::format(", object '{}'", self.object));
      });
}

void bind_result(nb::module_& module) {
  nb::class_<Plan> bound(module, "Plan",
                         "A motion through waypoints, at rest in each, every sample of it free of "
                         "collision; or why there is none.");
  bind_pickle(bound);
  bound
      .def_prop_ro(
          "status", [](const Plan& self) { return std::string(pl::to_string(self.status)); },
          "'ok', 'invalid' where waypoints cannot be taken, or 'no_path'.")
      .def_ro("faults", &Plan::faults, "Of 'invalid': a waypoint's index, and why.")
      .def_prop_ro(
          "unreachable",
          [](const Plan& self) -> std::optional<std::size_t> {
            if (self.status != pl::PlanStatus::no_path) return std::nullopt;
            return self.unreachable;
          },
          "Of 'no_path': the waypoint to which there is none; else None.")
      .def_prop_ro("commands", &commands_of, "A HandCommand a tick of 10 ms, from start to end.",
                   nb::sig("def commands(self) -> list[palpate._core.HandCommand]"))
      .def_ro("samples", &Plan::samples, nb::rv_policy::copy,
              "The same as rows (T, 6 + A): mount x, y, z (m), yaw, pitch, roll, actuators (rad).")
      .def_ro("corners", &Plan::corners, nb::rv_policy::copy,
              "Rows of the path's vertices, all waypoints among them.")
      .def_ro("arrivals", &Plan::arrivals, "Sample at which each waypoint is reached.")
      .def_prop_ro("duration", &duration, "s.")
      .def_ro("checks", &Plan::checks, "Configurations that were checked for collision.")
      .def_ro("seconds", &Plan::seconds, "Of planning, s.")
      .def("__repr__", [](const Plan& self) {
        return fmt::format("Plan({}, {} corners, {:.2f} s of motion, planned in {:.0f} ms)",
                           pl::to_string(self.status), self.corners.rows(), duration(self),
                           1e3 * self.seconds);
      });
}

}  // namespace

void bind_plan(nb::module_& module) {
  bind_scene(module);
  bind_result(module);
  module.def(
      "plan", &plan, "waypoints"_a, "scene"_a, nb::kw_only(), "seed"_a = 0,
      "options"_a = nb::dict(),
      nb::sig("def plan(waypoints: numpy.typing.ArrayLike, scene: CollisionScene, *, seed: int = "
              "0, options: dict[str, typing.Any] = {}) -> Plan"),
      "A collision-free motion of mount and hand through waypoints, as `palpate plan` makes it "
      "(Sucan, Moll & Kavraki 2012).\n\nwaypoints (N, 6 + J): mount x, y, z (m), yaw, pitch, roll "
      "(rad), then the hand's joints (rad) in the order of its description. options: those of "
      "`palpate options plan` about the search, as {'planner': 'prm', 'limits.mount_speed': "
      "0.1}.\n\nRaises ValueError for another shape, fewer than two waypoints and options that "
      "there are not. That no motion is found is a status.");
}

}  // namespace palpate::python
