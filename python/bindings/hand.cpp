// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/hand.hpp"

#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <nanobind/trampoline.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "arrays.hpp"
#include "description_fields.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "python_hand.hpp"
#include "without_gil.hpp"

namespace palpate::python {

template <>
struct Fields<hand::TipContact> {
  static auto of(hand::TipContact& it) {
    return std::tie(it.p, it.n, it.f, it.point_sigma, it.normal_sigma);
  }
};
template <>
struct Fields<hand::HandReading> {
  static auto of(hand::HandReading& it) {
    return std::tie(it.time, it.joints, it.torques, it.mount.xyz, it.mount.ypr, it.mount_force,
                    it.contacts);
  }
};
template <>
struct Fields<hand::HandCommand> {
  static auto of(hand::HandCommand& it) {
    return std::tie(it.positions, it.mount.xyz, it.mount.ypr);
  }
};

namespace {

using namespace nb::literals;
using hand::HandCommand;
using hand::HandReading;
using hand::TipContact;

/// Numbers of joints or actuators.
hand::JointVector joint_vector(nb::handle values, const char* what) {
  const auto numbers = numbers_from(values, what);
  if (numbers.size() > static_cast<std::size_t>(hand::kMaxJoints)) {
    throw BadInput(
        fmt::format("{}: {} values, at most {} can be", what, numbers.size(), hand::kMaxJoints));
  }
  return Eigen::VectorXd::Map(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

TipContact make_contact(nb::handle point, nb::handle normal, nb::handle force, double point_sigma,
                        double normal_sigma) {
  const Eigen::Vector3d n =
      is_given(normal) ? vector_from(normal, "normal") : Eigen::Vector3d(Eigen::Vector3d::Zero());
  return {vector_from(point, "point"), n, vector_from(force, "force"), point_sigma, normal_sigma};
}

HandReading make_reading(double time, nb::handle joints, nb::handle torques, nb::handle mount_xyz,
                         nb::handle mount_ypr, nb::handle mount_force,
                         std::vector<std::vector<TipContact>> contacts) {
  HandReading reading;
  reading.time = time;
  reading.joints = joint_vector(joints, "joints");
  reading.torques = joint_vector(torques, "torques");
  reading.mount = {vector_from(mount_xyz, "mount_xyz"), vector_from(mount_ypr, "mount_ypr")};
  reading.mount_force = vector_from(mount_force, "mount_force");
  reading.contacts = std::move(contacts);
  return reading;
}

void bind_contact(nb::module_& module) {
  nb::class_<TipContact> contact(module, "TipContact",
                                 "One contact of a fingertip, in the frame of that finger's link.");
  bind_pickle(contact);
  contact
      .def(
          "__init__",
          [](TipContact* self, nb::object point, nb::object normal, nb::object force,
             double point_sigma, double normal_sigma) {
            new (self) TipContact(make_contact(point, normal, force, point_sigma, normal_sigma));
          },
          "point"_a, "normal"_a.none(), "force"_a, nb::kw_only(), "point_sigma"_a = 0.0,
          "normal_sigma"_a = 0.0,
          nb::sig("def __init__(self, point: numpy.typing.ArrayLike, normal: "
                  "numpy.typing.ArrayLike | None, force: numpy.typing.ArrayLike, *, point_sigma: "
                  "float = 0.0, normal_sigma: float = 0.0) -> None"),
          "point (3,), m; normal (3,): outward of the object, unit, None where the sensor measures "
          "none; force (3,): on the object, N; the sensor's own errors, m and rad, 0: it states "
          "none.\n\nRaises ValueError for other shapes.")
      .def_ro("point", &TipContact::p, nb::rv_policy::copy, "(3,), m.")
      .def_ro("normal", &TipContact::n, nb::rv_policy::copy,
              "Outward of the object, (3,), unit; zeros: not measured.")
      .def_ro("force", &TipContact::f, nb::rv_policy::copy, "On the object, (3,), N.")
      .def_ro("point_sigma", &TipContact::point_sigma, "m; 0: not stated.")
      .def_ro("normal_sigma", &TipContact::normal_sigma, "rad; 0: not stated.")
      .def("__repr__", [](const TipContact& self) {
        return fmt::format("TipContact(({:.4f}, {:.4f}, {:.4f}) m, {:.2f} N)", self.p.x(),
                           self.p.y(), self.p.z(), self.f.norm());
      });
}

void bind_reading(nb::module_& module) {
  nb::class_<HandReading> reading(module, "HandReading",
                                  "What the hand senses in one tick of 10 ms.");
  bind_pickle(reading);
  reading
      .def(
          "__init__",
          [](HandReading* self, double time, nb::object joints, nb::object torques,
             nb::object mount_xyz, nb::object mount_ypr, nb::object mount_force,
             std::vector<std::vector<TipContact>> contacts) {
            new (self) HandReading(make_reading(time, joints, torques, mount_xyz, mount_ypr,
                                                mount_force, std::move(contacts)));
          },
          "time"_a, "joints"_a, "torques"_a, "mount_xyz"_a, "mount_ypr"_a, "mount_force"_a,
          "contacts"_a,
          nb::sig("def __init__(self, time: float, joints: numpy.typing.ArrayLike, torques: "
                  "numpy.typing.ArrayLike, mount_xyz: numpy.typing.ArrayLike, mount_ypr: "
                  "numpy.typing.ArrayLike, mount_force: numpy.typing.ArrayLike, contacts: "
                  "list[list[TipContact]]) -> None"),
          "time, s; joints (J,), rad; torques (A,) of the actuators, N m; the measured mount: "
          "mount_xyz (3,), m, mount_ypr (3,): yaw, pitch, roll, rad; mount_force (3,), world axes: "
          "force of the arm on the hand beyond what holds the empty hand at rest, N, up when "
          "something hangs in it; contacts: a list for each finger. J, A and the number of fingers "
          "are the hand's, in the order of its "
          "description.\n\nRaises ValueError for other shapes.")
      .def_ro("time", &HandReading::time, "s.")
      .def_prop_ro(
          "joints", [](const HandReading& self) { return Eigen::VectorXd(self.joints); },
          "(J,), rad.")
      .def_prop_ro(
          "torques", [](const HandReading& self) { return Eigen::VectorXd(self.torques); },
          "Of the actuators, (A,), N m.")
      .def_prop_ro(
          "mount_xyz", [](const HandReading& self) { return self.mount.xyz; }, "(3,), m.")
      .def_prop_ro(
          "mount_ypr", [](const HandReading& self) { return self.mount.ypr; },
          "Yaw, pitch, roll, (3,), rad.")
      .def_ro("mount_force", &HandReading::mount_force, nb::rv_policy::copy, "(3,), world axes, N.")
      .def_prop_ro(
          "contacts", [](const HandReading& self) { return self.contacts; },
          "A list for each finger.")
      .def("__repr__", [](const HandReading& self) {
        return fmt::format("HandReading({:.2f} s, {} joints, mount force {:.2f} N)", self.time,
                           self.joints.size(), self.mount_force.norm());
      });
}

void bind_command(nb::module_& module) {
  nb::class_<HandCommand> command(module, "HandCommand",
                                  "Targets of the position controllers for the next tick.");
  bind_pickle(command);
  command
      .def(
          "__init__",
          [](HandCommand* self, nb::object positions, nb::object xyz, nb::object ypr) {
            new (self) HandCommand{joint_vector(positions, "positions"),
                                   {vector_from(xyz, "mount_xyz"), vector_from(ypr, "mount_ypr")}};
          },
          "positions"_a, "mount_xyz"_a, "mount_ypr"_a,
          nb::sig("def __init__(self, positions: numpy.typing.ArrayLike, mount_xyz: "
                  "numpy.typing.ArrayLike, mount_ypr: numpy.typing.ArrayLike) -> None"),
          "positions (A,) of the actuators, rad; mount_xyz (3,), m; mount_ypr (3,): yaw, pitch, "
          "roll, rad.\n\nRaises ValueError for other shapes.")
      .def_prop_ro(
          "positions", [](const HandCommand& self) { return Eigen::VectorXd(self.positions); },
          "Of the actuators, (A,), rad.")
      .def_prop_ro(
          "mount_xyz", [](const HandCommand& self) { return self.mount.xyz; }, "(3,), m.")
      .def_prop_ro(
          "mount_ypr", [](const HandCommand& self) { return self.mount.ypr; },
          "Yaw, pitch, roll, (3,), rad.")
      .def_prop_ro(
          "T_world_mount", [](const HandCommand& self) { return pose(self.mount.pose()); },
          "The mount's pose, (4, 4), m.")
      .def("__repr__", [](const HandCommand& self) {
        return fmt::format("HandCommand({} actuators, mount at ({:.3f}, {:.3f}, {:.3f}) m)",
                           self.positions.size(), self.mount.xyz.x(), self.mount.xyz.y(),
                           self.mount.xyz.z());
      });
}

struct HandTrampoline final : PythonHand {
  NB_TRAMPOLINE(PythonHand, 2);

  std::optional<HandReading> sense() override {
    const WithGil acquire;
    try {
      NB_OVERRIDE(sense);
    } catch (const nb::python_error& error) {
      raised.keep(error);
    } catch (const std::bad_cast&) {
      throw std::runtime_error("sense() returned something else than a HandReading or None");
    }
  }

  HandReading step(const HandCommand& command) override {
    const WithGil acquire;
    try {
      NB_OVERRIDE_PURE(step, command);
    } catch (const nb::python_error& error) {
      raised.keep(error);
    } catch (const std::bad_cast&) {
      throw std::runtime_error("step() returned something else than a HandReading");
    }
  }
};

}  // namespace

void bind_hand(nb::module_& module) {
  bind_contact(module);
  bind_reading(module);
  bind_command(module);
  nb::class_<DescribedHand, HandTrampoline>(
      module, "Hand",
      "A hand with tactile fingertips on a 6-DoF mount. Subclass it and write step(command): apply "
      "the command for one tick of 10 ms and return the HandReading at its end. An exception in "
      "it, another answer, or one that comes too late (safety.watchdog) is a fault that stops a "
      "pick.")
      .def(nb::init<hand::Description>(), "description"_a,
           "A hand of this description, as the pick is to believe it.")
      .def_prop_ro("description", &DescribedHand::description, nb::rv_policy::reference_internal,
                   "As the pick believes it.")
      .def(
          "sense", &DescribedHand::sense, nb::call_guard<WithoutGil>(),
          "May be written: what the hand senses before its first command, which it is not given if "
          "it stands elsewhere than it is said to; None: that is sensed in step() alone.")
      .def("step", &DescribedHand::step, "command"_a, nb::call_guard<WithoutGil>(),
           "Apply a command for one tick and return what was sensed at its end.")
      .def("__repr__", [](const DescribedHand& self) {
        return fmt::format("Hand('{}')", self.description().name);
      });
}

}  // namespace palpate::python
