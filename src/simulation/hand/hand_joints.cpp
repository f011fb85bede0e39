// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/hand_joints.hpp"

#include <fmt/format.h>

#include <numbers>
#include <string>

#include "palpate/core/error.hpp"
#include "palpate/hand/coupling.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

constexpr std::array<double, 2> kLimitTime = {0.005, 1};  // s, damping ratio: nearly rigid
constexpr double kServoDamping = 0.01;  // N m s/rad, the D of the fingers' controllers

mjsElement& find(mjSpec& spec, mjtObj type, const std::string& name) {
  mjsElement* element = mjs_findElement(&spec, type, name.c_str());
  if (!element) {
    throw BadInput(fmt::format("the hand's model has no {} {}", mju_type2Str(type), name));
  }
  return *element;
}

mjsJoint& find_joint(mjSpec& spec, std::string_view name) {
  return *mjs_asJoint(&find(spec, mjOBJ_JOINT, mjcf_joint(name)));
}

mjsActuator& find_actuator(mjSpec& spec, std::string_view name) {
  return *mjs_asActuator(&find(spec, mjOBJ_ACTUATOR, mjcf_actuator(name)));
}

hand::Range range_of(std::string_view joint) {
  return hand::shadow_ranges()[static_cast<std::size_t>(hand::joint_index(joint))];
}

void set_ranges(mjSpec& spec) {
  for (std::string_view name : hand::kJointNames) {
    const hand::Range range = range_of(name);
    Eigen::Vector2d::Map(find_joint(spec, name).range) << range.low, range.high;
  }
  for (std::string_view name : hand::kActuatorNames) {
    const std::string finger(name.substr(0, 3));
    const hand::Range range =
        name.back() != '0' ? range_of(name)
                           : hand::Range{range_of(finger + "1").low + range_of(finger + "2").low,
                                         range_of(finger + "1").high + range_of(finger + "2").high};
    Eigen::Vector2d::Map(find_actuator(spec, name).ctrlrange) << range.low, range.high;
  }
}

/// A tendon of length J2 - J1 that is taut at 0, slack up to the angle from which J2 draws J1
/// along, and a spring beyond.
void add_difference(mjSpec& spec, const std::string& finger, const hand::Coupling& coupling) {
  mjsTendon* tendon = mjs_addTendon(&spec, nullptr);
  mjs_setName(tendon->element, ("coupling_" + finger).c_str());
  mjs_wrapJoint(tendon, mjcf_joint(finger + "J2").c_str(), 1);
  mjs_wrapJoint(tendon, mjcf_joint(finger + "J1").c_str(), -1);
  tendon->stiffness[0] = coupling.draw_stiffness;
  Eigen::Vector2d::Map(tendon->springlength) << 0, coupling.follow_angle;
  tendon->limited = mjLIMITED_TRUE;
  Eigen::Vector2d::Map(tendon->range) << 0, std::numbers::pi;
  Eigen::Vector2d::Map(tendon->solref_limit) << kLimitTime[0], kLimitTime[1];
}

void couple(mjSpec& spec, const std::string& finger, const hand::Coupling& coupling) {
  mjsJoint& distal = find_joint(spec, finger + "J1");
  distal.stiffness[0] = coupling.return_stiffness;
  distal.springref = -coupling.return_torque / coupling.return_stiffness;
  distal.damping[0] = coupling.distal_damping - kServoDamping;
  find_joint(spec, finger + "J2").damping[0] = coupling.middle_damping - kServoDamping;
  add_difference(spec, finger, coupling);
}

/// Position servos: torque = P (setpoint - q) - D dq/dt. The D comes out of the joints' damping, of
/// which the maker's model has all.
void set_servos(mjSpec& spec, double stiffness_scale) {
  for (std::string_view name : hand::kActuatorNames) {
    if (hand::finger_of_actuator(hand::actuator_index(name)) < 0) continue;
    mjsActuator& actuator = find_actuator(spec, name);
    actuator.gainprm[0] *= stiffness_scale;
    actuator.biasprm[1] *= stiffness_scale;
    actuator.biasprm[2] = -kServoDamping;
    if (name.back() != '0') find_joint(spec, name).damping[0] -= kServoDamping;
  }
}

}  // namespace

void prepare_joints(mjSpec& spec, const WorldOptions& options) {
  set_ranges(spec);
  for (const std::string finger : {"FF", "MF", "RF", "LF"}) {
    couple(spec, finger, hand::kShadowCoupling);
  }
  set_servos(spec, options.stiffness_scale);
}

}  // namespace palpate::simulation
