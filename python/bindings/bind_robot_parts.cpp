// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/nearest_mount.hpp"
#include "robot_parts.hpp"

namespace palpate::python {
namespace {

using namespace nb::literals;
using hand::ArmReading;
using hand::MountLimits;
using hand::MountPosition;

void bind_mount_position(nb::module_& module) {
  nb::class_<MountPosition>(module, "MountPosition", "Where a hand's mount is, in the world.")
      .def(
          "__init__",
          [](MountPosition* self, nb::object xyz, nb::object ypr) {
            new (self) MountPosition{vector_from(xyz, "xyz"), vector_from(ypr, "ypr")};
          },
          "xyz"_a, "ypr"_a,
          nb::sig("def __init__(self, xyz: numpy.typing.ArrayLike, ypr: numpy.typing.ArrayLike) -> "
                  "None"),
          "xyz (3,), m; ypr (3,): yaw, pitch, roll, rad; T_world_mount = Trans(xyz) Rz(yaw) "
          "Ry(pitch) Rx(roll).\n\nRaises ValueError for other shapes.")
      .def_static(
          "at",
          [](nb::object T, const MountPosition* near) {
            const Eigen::Isometry3d pose = pose_from(T, "T_world_mount");
            return near ? hand::nearest_mount(pose, *near) : MountPosition::at(pose);
          },
          "T_world_mount"_a, nb::kw_only(), "near"_a = nb::none(),
          nb::sig("def at(T_world_mount: numpy.typing.ArrayLike, *, near: MountPosition | None = "
                  "None) -> MountPosition"),
          "Of a pose (4, 4): with a pitch of at most a quarter turn, or with the yaw, pitch and "
          "roll that are nearest to another's.\n\nRaises ValueError unless it is a rigid motion.")
      .def_ro("xyz", &MountPosition::xyz, nb::rv_policy::copy, "(3,), m.")
      .def_ro("ypr", &MountPosition::ypr, nb::rv_policy::copy, "Yaw, pitch, roll, (3,), rad.")
      .def_prop_ro(
          "T_world_mount", [](const MountPosition& self) { return pose(self.pose()); }, "(4, 4).")
      .def("__repr__", [](const MountPosition& self) {
        return fmt::format(
            "MountPosition(({:.3f}, {:.3f}, {:.3f}) m, ({:.3f}, {:.3f}, {:.3f}) rad)", self.xyz.x(),
            self.xyz.y(), self.xyz.z(), self.ypr.x(), self.ypr.y(), self.ypr.z());
      });
}

void bind_arm_reading(nb::module_& module) {
  nb::class_<ArmReading>(module, "ArmReading", "What an arm measures at the end of a tick.")
      .def(
          "__init__",
          [](ArmReading* self, const MountPosition& mount, nb::object force) {
            new (self) ArmReading{mount, vector_from(force, "mount_force")};
          },
          "mount"_a, "mount_force"_a,
          nb::sig(
              "def __init__(self, mount: MountPosition, mount_force: numpy.typing.ArrayLike) -> "
              "None"),
          "mount: measured, of the hand's mount in the world; mount_force (3,), world axes: force "
          "of the arm on the hand beyond what holds the empty hand at rest, N, up when something "
          "hangs in it.\n\nRaises ValueError for other shapes.")
      .def_ro("mount", &ArmReading::mount, "Of the hand's mount in the world.")
      .def_ro("mount_force", &ArmReading::force, nb::rv_policy::copy, "(3,), world axes, N.")
      .def("__repr__", [](const ArmReading& self) {
        return fmt::format("ArmReading(({:.3f}, {:.3f}, {:.3f}) m, {:.2f} N)", self.mount.xyz.x(),
                           self.mount.xyz.y(), self.mount.xyz.z(), self.force.norm());
      });
}

MountLimits mount_limits(double acceleration, double turn_acceleration, double guarded_speed) {
  const auto check = [](const char* name, double value) {
    if (!(value > 0)) throw BadInput(fmt::format("{} is {}, not positive", name, value));
  };
  check("acceleration", acceleration);
  check("turn_acceleration", turn_acceleration);
  check("guarded_speed", guarded_speed);
  return {acceleration, turn_acceleration, guarded_speed};
}

/// What a subclass has to write.
template <class Part, class... Arguments>
auto unwritten(const char* text) {
  return [text](const Part&, const Arguments&...) -> nb::object {
    PyErr_SetString(PyExc_NotImplementedError, text);
    throw nb::python_error();
  };
}

void bind_arm(nb::module_& module) {
  nb::class_<PythonArm>(
      module, "Arm",
      "What carries a hand's mount, with a connection of its own. Subclass it, write move(target) "
      "and read(), and give it to palpate.sim.pick(..., arm=). In each tick of 10 ms move() is "
      "called, then the hand's step(), which lasts the tick, then read(). An exception, another "
      "answer, and one that comes too late are faults that name the arm and stop the pick.")
      .def(
          "__init__",
          [](PythonArm* self, std::string name, double acceleration, double turn_acceleration,
             double guarded_speed) {
            new (self) PythonArm(std::move(name),
                                 mount_limits(acceleration, turn_acceleration, guarded_speed));
          },
          "name"_a, nb::kw_only(), "acceleration"_a = 3.0, "turn_acceleration"_a = 10.0,
          "guarded_speed"_a = 0.02,
          "name: in messages; acceleration, m/s^2, and turn_acceleration, rad/s^2: at most these "
          "are asked of it; guarded_speed, m/s: towards a touch.\n\nRaises ValueError for numbers "
          "that are not positive.")
      .def_prop_ro("name", &PythonArm::name, "In messages.")
      .def("move", unwritten<PythonArm, MountPosition>("an Arm's move(target) has to be written"),
           "target"_a,
           "To be written: bring the hand's mount there by the end of this tick, and return at "
           "once.\n\ntarget: in the world. Raises NotImplementedError.")
      .def("read", unwritten<PythonArm>("an Arm's read() has to be written"),
           nb::sig("def read(self) -> ArmReading | None"),
           "To be written: what is measured at the end of the tick; None where there is nothing "
           "newer than the last answer, for 0.25 s at most.\n\nRaises NotImplementedError.")
      .def(
          "check_path",
          [](const PythonArm&, const std::vector<MountPosition>&) -> nb::object {
            return nb::str("");
          },
          "way"_a,
          nb::sig("def check_path(self, way: list[MountPosition]) -> str | PathFeasibility"),
          "May be written: why the arm cannot bring the mount along this way, one position a tick "
          "of 10 ms, in words, empty if it can; or what ArmFollower.check_path() answers. Called "
          "before each motion.")
      .def("__repr__", [](const PythonArm& self) { return fmt::format("Arm('{}')", self.name()); });
}

void bind_sensor(nb::module_& module) {
  nb::class_<PythonSensor>(
      module, "Sensor",
      "A tactile sensor of one fingertip, with a connection of its own. Subclass it, write read(), "
      "and give it to palpate.sim.pick(..., sensors=[...]). What it senses takes the place of what "
      "the hand's readings say of that finger; several on one finger add up. An exception, another "
      "answer, and one that comes too late are faults that name the sensor and stop the pick.")
      .def(nb::init<std::string>(), "finger"_a,
           "On the finger of this name in the hand's description.")
      .def_prop_ro("finger", &PythonSensor::finger, "Name of the finger that it is on.")
      .def("read", unwritten<PythonSensor>("a Sensor's read() has to be written"),
           nb::sig("def read(self) -> Contacts | list[TipContact] | None"),
           "To be written: what is sensed at the end of the tick of 10 ms, in the frame of the "
           "fingertip's link, with forces; None where there is nothing newer than the last "
           "answer, for 0.25 s at most.\n\nRaises NotImplementedError.")
      .def("__repr__",
           [](const PythonSensor& self) { return fmt::format("Sensor('{}')", self.finger()); });
}

}  // namespace

void bind_robot_parts(nb::module_& module) {
  bind_mount_position(module);
  bind_arm_reading(module);
  bind_arm_kinematics(module);
  bind_arm(module);
  bind_sensor(module);
}

}  // namespace palpate::python
