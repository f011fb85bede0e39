// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/arm.hpp"

#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/arm_follower.hpp"
#include "robot_parts.hpp"
#include "without_gil.hpp"

namespace palpate::python {
namespace {

using namespace nb::literals;
using hand::ArmDescription;
using hand::ArmFollower;
using hand::ArmJoint;
using hand::ArmVector;
using hand::MountPosition;
using hand::PathFeasibility;

void check_positive(const char* name, double value) {
  if (!(value > 0)) throw BadInput(fmt::format("{} is {}, not positive", name, value));
}

/// An angle for each of the arm's joints.
ArmVector joints_from(const ArmDescription& arm, nb::handle values, const char* what) {
  const auto numbers = numbers_from(values, what);
  const auto count = static_cast<Eigen::Index>(numbers.size());
  if (count != arm.joint_count()) {
    throw BadInput(fmt::format("{}: {} values for {} joints", what, count, arm.joint_count()));
  }
  ArmVector joints = Eigen::VectorXd::Map(numbers.data(), count);
  if (!joints.allFinite()) throw BadInput(fmt::format("{} holds a value that is not finite", what));
  return joints;
}

Eigen::VectorXd array_of(const ArmVector& joints) { return joints; }

ArmJoint make_joint(std::string name, std::pair<double, double> range, double max_speed,
                    double max_acceleration) {
  if (!(range.first < range.second)) {
    throw BadInput(fmt::format("range is {} to {} rad", range.first, range.second));
  }
  check_positive("max_speed", max_speed);
  check_positive("max_acceleration", max_acceleration);
  return {std::move(name), {range.first, range.second}, max_speed, max_acceleration};
}

void check_count(const char* what, std::size_t found, std::size_t joints) {
  if (found != joints) throw BadInput(fmt::format("{}: {} for {} joints", what, found, joints));
}

std::vector<hand::Link> chain_of(const std::vector<ArmJoint>& joints, nb::handle poses,
                                 nb::handle axes) {
  const auto directions = points_from(axes, "axes");
  std::vector<Eigen::Isometry3d> frames;
  for (const nb::handle T : poses) frames.push_back(pose_from(T, "T_parent_link"));
  check_count("T_parent_link", frames.size(), joints.size());
  check_count("axes", directions.size(), joints.size());
  std::vector<hand::Link> links;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double length = directions[i].norm();
    if (!(length > 1e-6 && std::isfinite(length))) {
      throw BadInput(fmt::format("axis {} has no direction", i));
    }
    const int index = static_cast<int>(i);
    links.push_back({joints[i].name, index - 1, frames[i], directions[i] / length, index});
  }
  return links;
}

/// Rows of link, x, y, z, radius.
std::vector<hand::LinkSphere> spheres_from(nb::handle values, std::size_t links) {
  std::vector<hand::LinkSphere> spheres;
  if (!is_given(values)) return spheres;
  const Matrix rows = matrix_from(values, "spheres");
  if (rows.size() == 0) return spheres;
  if (rows.cols() != 5) {
    throw BadInput(fmt::format("spheres has shape ({}, {}), not (S, 5): link, x, y, z, radius",
                               rows.rows(), rows.cols()));
  }
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const double link = rows(i, 0);
    const bool known = link >= 0 && link < static_cast<double>(links) && link == std::floor(link);
    if (!known || !(rows(i, 4) > 0) || !rows.row(i).allFinite()) {
      throw BadInput(
          fmt::format("sphere {} is on link {} of {}, of radius {} m", i, link, links, rows(i, 4)));
    }
    spheres.push_back({static_cast<int>(link), rows.row(i).segment<3>(1).transpose(), rows(i, 4)});
  }
  return spheres;
}

Eigen::Isometry3d pose_or(nb::handle T, const char* what, const Eigen::Isometry3d& otherwise) {
  return is_given(T) ? pose_from(T, what) : otherwise;
}

ArmDescription make_arm(std::string name, std::vector<ArmJoint> joints, nb::handle T_parent_link,
                        nb::handle axes, nb::handle T_world_stand, nb::handle T_flange_mount,
                        nb::handle spheres) {
  const auto count = joints.size();
  if (count < 1 || count > static_cast<std::size_t>(hand::kMaxArmJoints)) {
    throw BadInput(fmt::format("an arm has 1 to {} joints, not {}", hand::kMaxArmJoints, count));
  }
  ArmDescription arm;
  arm.name = std::move(name);
  arm.links = chain_of(joints, T_parent_link, axes);
  arm.joints = std::move(joints);
  arm.spheres = spheres_from(spheres, count);
  arm.flange = static_cast<int>(count) - 1;
  arm.T_world_stand = pose_or(T_world_stand, "T_world_stand", arm.T_world_stand);
  arm.T_flange_mount = pose_or(T_flange_mount, "T_flange_mount", arm.T_flange_mount);
  return arm;
}

ArmDescription with_mounting(ArmDescription arm, nb::handle stand, nb::handle mount) {
  arm.T_world_stand = pose_or(stand, "T_world_stand", arm.T_world_stand);
  arm.T_flange_mount = pose_or(mount, "T_flange_mount", arm.T_flange_mount);
  return arm;
}

void bind_joint(nb::module_& module) {
  nb::class_<ArmJoint>(module, "ArmJoint", "A hinge of an arm, and how far and fast it turns.")
      .def(
          "__init__",
          [](ArmJoint* self, std::string name, std::pair<double, double> range, double speed,
             double acceleration) {
            new (self) ArmJoint(make_joint(std::move(name), range, speed, acceleration));
          },
          "name"_a, "range"_a, nb::kw_only(), "max_speed"_a = 2.0, "max_acceleration"_a = 15.0,
          "range: low, high, rad; max_speed, rad/s; max_acceleration, rad/s^2.\n\nRaises "
          "ValueError "
          "for an empty range and limits that are not positive.")
      .def_ro("name", &ArmJoint::name, "In messages.")
      .def_prop_ro(
          "range", [](const ArmJoint& self) { return std::pair(self.range.low, self.range.high); },
          "Low, high, rad.")
      .def_ro("max_speed", &ArmJoint::max_speed, "rad/s.")
      .def_ro("max_acceleration", &ArmJoint::max_acceleration, "rad/s^2.")
      .def("__repr__", [](const ArmJoint& self) {
        return fmt::format("ArmJoint('{}', {:.2f} to {:.2f} rad, {:.2f} rad/s)", self.name,
                           self.range.low, self.range.high, self.max_speed);
      });
}

void bind_kinematics(nb::class_<ArmDescription>& arm) {
  arm.def(
         "mount_pose",
         [](const ArmDescription& self, nb::object joints) {
           return pose(hand::mount_pose(self, joints_from(self, joints, "joints")));
         },
         "joints"_a,
         nb::sig("def mount_pose(self, joints: numpy.typing.ArrayLike) -> "
                 "numpy.typing.NDArray[numpy.float64]"),
         "T_world_mount of the hand (4, 4) at joints (J,), rad.\n\nRaises ValueError for another "
         "number of joints.")
      .def(
          "mount_jacobian",
          [](const ArmDescription& self, nb::object joints) {
            return Matrix(hand::mount_jacobian(self, joints_from(self, joints, "joints")));
          },
          "joints"_a,
          nb::sig("def mount_jacobian(self, joints: numpy.typing.ArrayLike) -> "
                  "numpy.typing.NDArray[numpy.float64]"),
          "Geometric Jacobian (6, J) of the mount at joints (J,), rad: [w; v], world axes, 1 and "
          "m.\n\nRaises ValueError for another number of joints.")
      .def(
          "inverse_kinematics",
          [](const ArmDescription& self, nb::object T,
             nb::object near) -> std::optional<Eigen::VectorXd> {
            const auto found = hand::inverse_kinematics(self, pose_from(T, "T_world_mount"),
                                                        joints_from(self, near, "near"));
            return found ? std::optional(array_of(*found)) : std::nullopt;
          },
          "T_world_mount"_a, "near"_a,
          nb::sig("def inverse_kinematics(self, T_world_mount: numpy.typing.ArrayLike, near: "
                  "numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64] | None"),
          "Joints (J,), rad, within their ranges, that bring the hand's mount to a pose (4, 4), to "
          "10 um and 10 urad: those that damped least squares (Wampler 1986) finds from near (J,); "
          "None where there are none or the search ends at a limit.\n\nRaises ValueError unless it "
          "is a pose.")
      .def(
          "inverse_kinematics_branches",
          [](const ArmDescription& self, nb::object T) {
            std::vector<Eigen::VectorXd> branches;
            for (const auto& one :
                 hand::inverse_kinematics_branches(self, pose_from(T, "T_world_mount"))) {
              branches.push_back(array_of(one));
            }
            return branches;
          },
          "T_world_mount"_a,
          nb::sig("def inverse_kinematics_branches(self, T_world_mount: numpy.typing.ArrayLike) -> "
                  "list[numpy.typing.NDArray[numpy.float64]]"),
          "Different solutions (J,), rad, for a pose (4, 4), from a fixed set of starts; those of "
          "a redundant arm are examples.\n\nRaises ValueError unless it is a pose.")
      .def(
          "collision",
          [](const ArmDescription& self, nb::object joints) {
            return hand::arm_collision(self, joints_from(self, joints, "joints"));
          },
          "joints"_a, nb::sig("def collision(self, joints: numpy.typing.ArrayLike) -> str"),
          "What the arm overlaps at joints (J,), rad, in words: the table (z = 0) or itself; empty "
          "if nothing. What stands on the table is not looked at.\n\nRaises ValueError for another "
          "number of joints.");
}

void bind_description(nb::module_& module) {
  nb::class_<ArmDescription> arm(module, "ArmDescription",
                                 "An arm as data: a chain of hinges that stands in the world and "
                                 "carries a hand's mount.");
  arm.def(
         "__init__",
         [](ArmDescription* self, std::string name, std::vector<ArmJoint> joints, nb::object poses,
            nb::object axes, nb::object stand, nb::object mount, nb::object spheres) {
           new (self) ArmDescription(
               make_arm(std::move(name), std::move(joints), poses, axes, stand, mount, spheres));
         },
         "name"_a, "joints"_a, "T_parent_link"_a, "axes"_a, nb::kw_only(),
         "T_world_stand"_a = nb::none(), "T_flange_mount"_a = nb::none(), "spheres"_a = nb::none(),
         nb::sig("def __init__(self, name: str, joints: collections.abc.Sequence[ArmJoint], "
                 "T_parent_link: numpy.typing.ArrayLike, axes: numpy.typing.ArrayLike, *, "
                 "T_world_stand: numpy.typing.ArrayLike | None = None, T_flange_mount: "
                 "numpy.typing.ArrayLike | None = None, spheres: numpy.typing.ArrayLike | None = "
                 "None) -> None"),
         "joints: 1 to 8 from the stand on; each turns a link: T_parent_link (J, 4, 4), of the "
         "link "
         "in the one before at angle 0, and axes (J, 3) in the links' frames. The last link is the "
         "flange. T_world_stand, T_flange_mount (4, 4): the identity if not given. spheres (S, 5): "
         "link, x, y, z in its frame, radius, m, which stand for the surface; without them no "
         "collision is found.\n\nRaises ValueError, naming what does not fit.")
      .def_ro("name", &ArmDescription::name, "In messages.")
      .def_ro("joints", &ArmDescription::joints, "From the stand on.")
      .def_prop_ro(
          "T_world_stand", [](const ArmDescription& self) { return pose(self.T_world_stand); },
          "Where it stands, (4, 4), m.")
      .def_prop_ro(
          "T_flange_mount", [](const ArmDescription& self) { return pose(self.T_flange_mount); },
          "How the hand is fixed to it, (4, 4), m.")
      .def(
          "with_mounting", &with_mounting, nb::kw_only(), "T_world_stand"_a = nb::none(),
          "T_flange_mount"_a = nb::none(),
          nb::sig("def with_mounting(self, *, T_world_stand: numpy.typing.ArrayLike | None = None, "
                  "T_flange_mount: numpy.typing.ArrayLike | None = None) -> ArmDescription"),
          "The same arm that stands elsewhere, or carries the hand otherwise: poses (4, 4), as "
          "they are where not given.\n\nRaises ValueError for what is no pose.")
      .def("__repr__", [](const ArmDescription& self) {
        return fmt::format("ArmDescription('{}', {} joints)", self.name, self.joint_count());
      });
  bind_kinematics(arm);
}

void bind_feasibility(nb::module_& module) {
  nb::class_<PathFeasibility>(module, "PathFeasibility",
                              "Whether an arm can take the hand's mount along a way.")
      .def(
          "__init__",
          [](PathFeasibility* self, std::string obstacle, std::size_t feasible, double stretch) {
            if (!(stretch >= 1 && std::isfinite(stretch))) {
              throw BadInput(fmt::format("stretch is {}, not at least 1", stretch));
            }
            new (self) PathFeasibility{std::move(obstacle), feasible, stretch};
          },
          "obstacle"_a = "", nb::kw_only(), "feasible"_a = 0, "stretch"_a = 1.0,
          "obstacle: why it cannot, in words; empty: it can. feasible: positions before the "
          "obstacle. stretch: times as long as wanted that it takes.\n\nRaises ValueError for a "
          "stretch below 1.")
      .def_ro("obstacle", &PathFeasibility::obstacle, "Why it cannot, in words; empty: it can.")
      .def_ro("feasible", &PathFeasibility::feasible, "Positions before the obstacle.")
      .def_ro("stretch", &PathFeasibility::stretch,
              "Times as long as wanted these take, at least; 1: not longer.")
      .def("__repr__", [](const PathFeasibility& self) {
        return self.obstacle.empty()
                   ? fmt::format("PathFeasibility(stretch {:.2f})", self.stretch)
                   : fmt::format("PathFeasibility('{}' after {})", self.obstacle, self.feasible);
      });
}

/// @throws std::logic_error for a follower that stands nowhere yet
const ArmFollower& started(const ArmFollower& follower) {
  if (follower.joints().size() == 0) {
    throw std::logic_error("an ArmFollower's reset() has to be called first");
  }
  return follower;
}

void bind_follower(nb::module_& module) {
  nb::class_<ArmFollower>(
      module, "ArmFollower",
      "Converts commanded poses of a hand's mount to commands of an arm's joints, once per tick of "
      "10 ms, by inverse kinematics from the joints of the tick before, within the joints' ranges, "
      "speeds "
      "and accelerations.")
      .def(nb::init<ArmDescription>(), "arm"_a, "Follows with this arm, once reset() was called.")
      .def_prop_ro("arm", &ArmFollower::arm, nb::rv_policy::reference_internal,
                   "That it follows with.")
      .def_prop_ro(
          "joints", [](const ArmFollower& self) { return array_of(self.joints()); },
          "As last commanded, (J,), rad; (0,) before reset().")
      .def(
          "reset",
          [](ArmFollower& self, nb::object T, const std::vector<MountPosition>& tour) {
            const Eigen::Isometry3d T_world_mount = pose_from(T, "T_world_mount");
            const WithoutGil release;
            return array_of(self.reset(T_world_mount, tour));
          },
          "T_world_mount"_a, "tour"_a = nb::list(),
          nb::sig("def reset(self, T_world_mount: numpy.typing.ArrayLike, tour: "
                  "collections.abc.Sequence[MountPosition] = []) -> "
                  "numpy.typing.NDArray[numpy.float64]"),
          "Starts at a pose of the mount (4, 4): joints (J,), rad, of the branch of the inverse "
          "kinematics from which most of the tour can be followed; see working_tour().\n\nRaises "
          "ValueError if the arm cannot hold the mount there.")
      .def(
          "follow",
          [](ArmFollower& self, nb::object T) {
            started(self);
            return array_of(self.follow(pose_from(T, "T_world_mount")));
          },
          "T_world_mount"_a,
          nb::sig("def follow(self, T_world_mount: numpy.typing.ArrayLike) -> "
                  "numpy.typing.NDArray[numpy.float64]"),
          "Joints (J,), rad, for the next tick, towards a pose of the mount (4, 4). Where the arm "
          "cannot follow, it comes as near as it can.\n\nRaises ValueError unless it is a pose, "
          "RuntimeError before reset().")
      .def(
          "check_path",
          [](const ArmFollower& self, const std::vector<MountPosition>& way) {
            const WithoutGil release;
            return started(self).check_path(way);
          },
          "way"_a,
          "Whether the arm can follow a way that starts where it is commanded, one position a "
          "tick.\n\nRaises RuntimeError before reset().")
      .def("__repr__", [](const ArmFollower& self) {
        return fmt::format("ArmFollower('{}', {})", self.arm().name,
                           self.joints().size() == 0 ? "not reset" : "follows");
      });
}

}  // namespace

void bind_arm_kinematics(nb::module_& module) {
  bind_joint(module);
  bind_description(module);
  bind_feasibility(module);
  bind_follower(module);
  module.def("working_tour", &hand::working_tour, "description"_a,
             "A tour through the attitudes in which skills use a hand: each from all sides, above "
             "the workspace's middle and above the table. For ArmFollower.reset().");
}

}  // namespace palpate::python
