// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "description_fields.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/hand/description.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::python {
namespace {

using namespace nb::literals;
using hand::Actuator;
using hand::Description;

std::pair<double, double> pair_of(const hand::Range& range) { return {range.low, range.high}; }

Description perturbed(const Description& hand, double rms, std::uint64_t seed) {
  if (!(rms >= 0)) throw BadInput(fmt::format("rms must be at least 0 m, not {}", rms));
  RandomStream random(seed, "links");
  return hand::with_perturbed_links(hand, rms, random);
}

void bind_link(nb::module_& module) {
  nb::class_<hand::Link>(module, "HandLink", "A rigid link and the hinge to its parent.")
      .def_ro("name", &hand::Link::name, "In the hand's file.")
      .def_ro("parent", &hand::Link::parent, "Index of the parent; -1: the mount.")
      .def_prop_ro(
          "T_parent_link", [](const hand::Link& self) { return pose(self.T_parent_link); },
          "At joint angle 0, (4, 4).")
      .def_ro("axis", &hand::Link::axis, nb::rv_policy::copy,
              "Of the joint, in the link's frame, (3,), unit.")
      .def_ro("joint", &hand::Link::joint, "Index of the joint; -1: fixed.")
      .def("__repr__",
           [](const hand::Link& self) { return fmt::format("HandLink('{}')", self.name); });
  nb::class_<hand::Joint>(module, "HandJoint", "A hinge.")
      .def_ro("name", &hand::Joint::name, "In the hand's file.")
      .def_prop_ro(
          "range", [](const hand::Joint& self) { return pair_of(self.range); }, "Low, high, rad.")
      .def("__repr__", [](const hand::Joint& self) {
        return fmt::format("HandJoint('{}', {:.3f} to {:.3f} rad)", self.name, self.range.low,
                           self.range.high);
      });
}

void bind_actuator(nb::module_& module) {
  nb::class_<Actuator>(module, "Actuator",
                       "A position controller: torque = stiffness (command - position) - damping "
                       "speed, within the limit. Its position is the sum of gear * angle.")
      .def_ro("name", &Actuator::name, "In the hand's file.")
      .def_prop_ro(
          "joints",
          [](const Actuator& self) {
            std::vector<std::pair<int, double>> joints;
            for (const auto& driven : self.joints) joints.emplace_back(driven.joint, driven.gear);
            return joints;
          },
          "Index and gear of each joint that it moves.")
      .def_prop_ro(
          "finger", [](const Actuator& self) { return self.finger; }, "-1: the palm.")
      .def_ro("stiffness", &Actuator::stiffness, "N m/rad.")
      .def_prop_ro(
          "command", [](const Actuator& self) { return pair_of(self.command); }, "Low, high, rad.")
      .def_ro("max_torque", &Actuator::max_torque, "N m.")
      .def_ro("damping", &Actuator::damping, "Of its joints, in simulation, N m s/rad.")
      .def_ro("armature", &Actuator::armature, "Of its joints' rotors, in simulation, kg m^2.")
      .def("__repr__", [](const Actuator& self) {
        return fmt::format("Actuator('{}', {:.3f} N m/rad, at most {:.2f} N m)", self.name,
                           self.stiffness, self.max_torque);
      });
}

void bind_finger(nb::module_& module) {
  nb::class_<hand::Finger>(module, "Finger", "A finger and its tip.")
      .def_ro("name", &hand::Finger::name, "In the hand's file.")
      .def_ro("link", &hand::Finger::link, "Index of the fingertip's link.")
      .def_prop_ro(
          "tip",
          [](const hand::Finger& self) {
            return std::tuple(self.tip.a, self.tip.b, self.tip.radius);
          },
          "Ends (3,) of the capsule's axis in the link's frame, the outer one second, m; radius, "
          "m.")
      .def_prop_ro(
          "hull",
          [](const hand::Finger& self) -> std::optional<std::pair<Eigen::MatrixX3d, double>> {
            if (!self.hull) return std::nullopt;
            Eigen::MatrixX3d core(static_cast<Eigen::Index>(self.hull->core.size()), 3);
            for (std::size_t i = 0; i < self.hull->core.size(); ++i) {
              core.row(static_cast<Eigen::Index>(i)) = self.hull->core[i].transpose();
            }
            return std::pair(core, self.hull->radius);
          },
          "None where the tip is the capsule; else corners (n, 3) in the link's frame and radius, "
          "m: the surface is all within the radius of their convex hull.")
      .def("__repr__",
           [](const hand::Finger& self) { return fmt::format("Finger('{}')", self.name); });
}

}  // namespace

void bind_hand_description(nb::module_& module) {
  bind_link(module);
  bind_actuator(module);
  bind_finger(module);
  nb::class_<Description> description(
      module, "HandDescription",
      "A hand as data: what moves, what senses, and what its surface is. The mount's frame: palm "
      "down, fingers along +x, z up.");
  bind_pickle(description);
  description.def_ro("name", &Description::name, "Of the hand, or its file.")
      .def_ro("links", &Description::links, "Parents first.")
      .def_ro("joints", &Description::joints, "In the order of HandReading.joints.")
      .def_ro("actuators", &Description::actuators, "In the order of HandCommand.positions.")
      .def_ro("fingers", &Description::fingers, "In the order of HandReading.contacts.")
      .def_prop_ro(
          "spheres",
          [](const Description& self) {
            std::vector<std::tuple<int, Eigen::Vector3d, double>> spheres;
            for (const auto& s : self.spheres) spheres.emplace_back(s.link, s.center, s.radius);
            return spheres;
          },
          "Balls that stand for the surface: link, center (3,) in its frame, m, radius, m.")
      .def_ro("kinematic_error", &Description::kinematic_error,
              "Assumed error of each link's position, rms, m.")
      .def("with_perturbed_links", &perturbed, "rms"_a, nb::kw_only(), "seed"_a = 0,
           "The same hand with every link displaced by a normal vector of root mean square length "
           "rms, m, which becomes its kinematic_error: how far a real hand is from its "
           "drawing.\n\nRaises ValueError for a negative rms.")
      .def("__repr__", [](const Description& self) {
        return fmt::format("HandDescription('{}', {} fingers, {} joints, {} actuators)", self.name,
                           self.finger_count(), self.joint_count(), self.actuator_count());
      });
}

}  // namespace palpate::python
