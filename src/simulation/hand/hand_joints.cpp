// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/hand_joints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <set>
#include <string>

#include "palpate/core/error.hpp"
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

const std::string& joint_name(const hand::Description& hand, const hand::DrivenJoint& driven) {
  return hand.joints[static_cast<std::size_t>(driven.joint)].name;
}

mjsJoint& find_joint(mjSpec& spec, const hand::Description& hand, const std::string& name) {
  return *mjs_asJoint(&find(spec, mjOBJ_JOINT, file_joint(hand, name)));
}

mjsActuator& find_actuator(mjSpec& spec, const hand::Description& hand,
                           const hand::Actuator& actuator) {
  return *mjs_asActuator(&find(spec, mjOBJ_ACTUATOR, file_actuator(hand, actuator.name)));
}

/// A radian in the units of the file that a joint is from.
double radian_of(const mjsJoint& joint) {
  return mjs_getCompiler(joint.element)->degree ? 180 / std::numbers::pi : 1;
}

void set_ranges(mjSpec& spec, const hand::Description& hand) {
  for (const hand::Joint& one : hand.joints) {
    mjsJoint& joint = find_joint(spec, hand, one.name);
    joint.limited = mjLIMITED_TRUE;
    Eigen::Vector2d::Map(joint.range) =
        radian_of(joint) * Eigen::Vector2d(one.range.low, one.range.high);
  }
  for (const hand::Actuator& one : hand.actuators) {
    mjsActuator& actuator = find_actuator(spec, hand, one);
    Eigen::Vector2d::Map(actuator.ctrlrange) << one.command.low, one.command.high;
  }
}

/// A tendon of length J2 - J1 that is taut at 0, slack up to the angle from which J2 draws J1
/// along, and a spring beyond.
void add_difference(mjSpec& spec, const std::string& actuator, const std::string& j2,
                    const std::string& j1, const hand::Coupling& coupling) {
  mjsTendon* tendon = mjs_addTendon(&spec, nullptr);
  mjs_setName(tendon->element, ("coupling_" + actuator).c_str());
  mjs_wrapJoint(tendon, j2.c_str(), 1);
  mjs_wrapJoint(tendon, j1.c_str(), -1);
  tendon->stiffness[0] = coupling.draw_stiffness;
  Eigen::Vector2d::Map(tendon->springlength) << 0, coupling.follow_angle;
  tendon->limited = mjLIMITED_TRUE;
  Eigen::Vector2d::Map(tendon->range) << 0, std::numbers::pi;
  Eigen::Vector2d::Map(tendon->solref_limit) << kLimitTime[0], kLimitTime[1];
}

void couple(mjSpec& spec, const hand::Description& hand, const hand::Actuator& actuator) {
  const hand::Coupling& coupling = *actuator.coupling;
  const std::string &j2 = joint_name(hand, actuator.joints[0]),
                    &j1 = joint_name(hand, actuator.joints[1]);
  mjsJoint& distal = find_joint(spec, hand, j1);
  distal.stiffness[0] = coupling.return_stiffness;
  distal.springref = -coupling.return_torque / coupling.return_stiffness;
  distal.damping[0] = coupling.distal_damping - kServoDamping;
  find_joint(spec, hand, j2).damping[0] = coupling.middle_damping - kServoDamping;
  add_difference(spec, actuator.name, file_joint(hand, j2), file_joint(hand, j1), coupling);
}

/// The servos of the hand's own file: torque = P (setpoint - q) - D dq/dt. The D comes out of the
/// joints' damping, of which the maker's model has all.
void scale_servos(mjSpec& spec, const hand::Description& hand, double stiffness_scale) {
  for (const hand::Actuator& one : hand.actuators) {
    if (one.finger < 0) continue;
    mjsActuator& actuator = find_actuator(spec, hand, one);
    actuator.gainprm[0] *= stiffness_scale;
    actuator.biasprm[1] *= stiffness_scale;
    actuator.biasprm[2] = -kServoDamping;
    if (!one.coupling) {
      find_joint(spec, hand, joint_name(hand, one.joints.front())).damping[0] -= kServoDamping;
    }
  }
}

/// A servo is all that moves a joint: springs of the file go.
void give_drive(mjsJoint& joint, const hand::Actuator& drive) {
  std::ranges::fill(joint.stiffness, 0);
  std::ranges::fill(joint.springdamper, 0);
  std::ranges::fill(joint.damping, 0);
  joint.springref = 0;
  joint.damping[0] = drive.damping;
  joint.armature = drive.armature;
  joint.frictionloss = 0;
}

void remove_actuators(mjSpec& spec) {
  while (mjsElement* element = mjs_firstElement(&spec, mjOBJ_ACTUATOR)) mjs_delete(&spec, element);
}

/// Position servos with the description's gains, in place of whatever the file has.
void add_servos(mjSpec& spec, const hand::Description& hand) {
  remove_actuators(spec);
  for (const hand::Actuator& one : hand.actuators) {
    const std::string joint = file_joint(hand, joint_name(hand, one.joints.front()));
    mjsActuator* actuator = mjs_addActuator(&spec, mjs_getSpecDefault(&spec));
    mjs_setName(actuator->element, file_actuator(hand, one.name).c_str());
    mjs_setString(actuator->target, joint.c_str());
    actuator->trntype = mjTRN_JOINT;
    double damping = kServoDamping;
    mjs_setToPosition(actuator, one.stiffness, &damping, nullptr, nullptr, 0);
    actuator->forcelimited = mjLIMITED_TRUE;
    Eigen::Vector2d::Map(actuator->forcerange) << -one.max_torque, one.max_torque;
    actuator->ctrllimited = mjLIMITED_TRUE;
    for (const hand::DrivenJoint& driven : one.joints) {
      give_drive(find_joint(spec, hand, joint_name(hand, driven)), one);
    }
  }
}

/// Names of joints that the model's own active equalities tie to one, or to one another, and that
/// one. What they lock is tied to the name "".
std::set<std::string> tied_to(const mjSpec& spec, const std::string& joint) {
  std::set<std::string> group{joint};
  for (std::size_t before = 0; before != group.size();) {
    before = group.size();
    for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_EQUALITY); e;
         e = mjs_nextElement(&spec, e)) {
      const mjsEquality& tie = *mjs_asEquality(e);
      if (tie.type != mjEQ_JOINT || !tie.active) continue;
      const std::string one = mjs_getString(tie.name1);
      const std::string other = tie.data[1] == 0 ? "" : mjs_getString(tie.name2);
      if (group.contains(one) || group.contains(other)) group.insert({one, other});
    }
  }
  return group;
}

/// An equality is written from where the file draws its joints.
double drawn_at(mjSpec& spec, const std::string& joint) {
  const mjsJoint& found = *mjs_asJoint(&find(spec, mjOBJ_JOINT, joint));
  return found.ref / radian_of(found);
}

/// Ties followers to their leaders, where the file's own equalities do not.
void add_mimics(mjSpec& spec, const hand::Description& hand) {
  for (const hand::Actuator& one : hand.actuators) {
    if (one.coupling) continue;
    const std::string leader = file_joint(hand, joint_name(hand, one.joints[0]));
    for (std::size_t i = 1; i < one.joints.size(); ++i) {
      const hand::DrivenJoint& driven = one.joints[i];
      const std::string follower = file_joint(hand, joint_name(hand, driven));
      if (tied_to(spec, driven.share == 0 ? "" : leader).contains(follower)) continue;
      mjsEquality* tie = mjs_addEquality(&spec, nullptr);
      tie->type = mjEQ_JOINT;
      tie->objtype = mjOBJ_JOINT;
      mjs_setString(tie->name1, follower.c_str());
      mjs_setString(tie->name2, leader.c_str());
      tie->data[0] =
          driven.offset - drawn_at(spec, follower) + driven.share * drawn_at(spec, leader);
      tie->data[1] = driven.share;
    }
  }
}

}  // namespace

void prepare_joints(mjSpec& spec, const hand::Description& hand, double stiffness_scale) {
  if (!hand.file.own_servos) {
    add_servos(spec, hand);
    add_mimics(spec, hand);
  }
  set_ranges(spec, hand);
  for (const hand::Actuator& actuator : hand.actuators) {
    if (actuator.coupling) couple(spec, hand, actuator);
  }
  if (hand.file.own_servos) scale_servos(spec, hand, stiffness_scale);
}

}  // namespace palpate::simulation
