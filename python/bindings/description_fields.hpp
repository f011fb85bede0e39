// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/pair.h>

#include <tuple>

#include "check_description.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/description.hpp"
#include "pickle.hpp"

namespace palpate::python {

// What pickles keep of the description of a hand: all of it.

template <>
struct Kept<hand::JointVector> {
  static nb::object of(const hand::JointVector& v) { return nb::cast(Eigen::VectorXd(v)); }
  static void into(nb::handle kept, hand::JointVector& v) {
    const auto all = nb::cast<Eigen::VectorXd>(kept);
    if (all.size() > hand::kMaxJoints) throw BadInput(fmt::format("{} joints", all.size()));
    v = all;
  }
};
template <>
struct Fields<hand::Range> {
  static auto of(hand::Range& it) { return std::tie(it.low, it.high); }
};
template <>
struct Fields<hand::Link> {
  static auto of(hand::Link& it) {
    return std::tie(it.name, it.parent, it.T_parent_link, it.axis, it.joint);
  }
};
template <>
struct Fields<hand::LinkSphere> {
  static auto of(hand::LinkSphere& it) { return std::tie(it.link, it.center, it.radius); }
};
template <>
struct Fields<hand::TipCapsule> {
  static auto of(hand::TipCapsule& it) { return std::tie(it.a, it.b, it.radius); }
};
template <>
struct Fields<hand::TipHull> {
  static auto of(hand::TipHull& it) { return std::tie(it.core, it.radius); }
};
template <>
struct Fields<hand::Finger> {
  static auto of(hand::Finger& it) { return std::tie(it.name, it.link, it.tip, it.hull); }
};
template <>
struct Fields<hand::Joint> {
  static auto of(hand::Joint& it) { return std::tie(it.name, it.range); }
};
template <>
struct Fields<hand::Coupling> {
  static auto of(hand::Coupling& it) {
    return std::tie(it.follow_angle, it.draw_stiffness, it.return_torque, it.return_stiffness,
                    it.distal_damping, it.middle_damping, it.middle_end);
  }
};
template <>
struct Fields<hand::DrivenJoint> {
  static auto of(hand::DrivenJoint& it) { return std::tie(it.joint, it.gear, it.share, it.offset); }
};
template <>
struct Fields<hand::Actuator> {
  static auto of(hand::Actuator& it) {
    return std::tie(it.name, it.joints, it.coupling, it.finger, it.stiffness, it.command,
                    it.max_torque, it.damping, it.armature, it.closing, it.lever, it.bend);
  }
};
template <>
struct Fields<hand::Attitude> {
  static auto of(hand::Attitude& it) { return std::tie(it.pitch, it.roll); }
};
template <>
struct Fields<hand::Preshape> {
  static auto of(hand::Preshape& it) {
    return std::tie(it.open, it.closed, it.contact_torque, it.attitudes, it.offset, it.height);
  }
};
template <>
struct Fields<hand::PointingHand> {
  static auto of(hand::PointingHand& it) { return std::tie(it.finger, it.positions, it.attitude); }
};
template <>
struct Fields<hand::FlatHand> {
  static auto of(hand::FlatHand& it) { return std::tie(it.positions, it.attitude, it.center); }
};
template <>
struct Fields<hand::Postures> {
  static auto of(hand::Postures& it) {
    return std::tie(it.flat, it.pointing, it.stretched, it.folded, it.released, it.top, it.side,
                    it.far_attitudes);
  }
};
template <>
struct Fields<hand::ModelFile> {
  static auto of(hand::ModelFile& it) {
    return std::tie(it.path, it.root, it.prefix, it.actuator_prefix, it.own_servos, it.T_mount_root,
                    it.overlapping);
  }
};
template <>
struct Fields<hand::Description> {
  static auto of(hand::Description& it) {
    return std::tie(it.name, it.links, it.palm, it.joints, it.actuators, it.fingers, it.thumb,
                    it.spheres, it.postures, it.file, it.kinematic_error);
  }
  static void check(const hand::Description& it) { check_description(it); }
};

}  // namespace palpate::python
