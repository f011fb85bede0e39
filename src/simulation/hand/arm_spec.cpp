// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/arm_spec.hpp"

#include <fmt/format.h>

#include <string>

#include "palpate/core/error.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

/// s, how late a joint follows: damping over stiffness, of the floating mount and so of the arm.
constexpr double kFollowingLag = 0.06325;

mjsElement& find_arm_part(mjSpec& spec, mjtObj type, const std::string& name) {
  mjsElement* element = mjs_findElement(&spec, type, name.c_str());
  if (!element) throw BadInput(fmt::format("the arm has no {} {}", mju_type2Str(type), name));
  return *element;
}

void prepare_arm(mjSpec& spec, const hand::ArmDescription& arm) {
  mjs_discardVisual(&spec, nullptr);
  Eigen::Vector3d::Map(find_body(spec, arm.file.root).pos).setZero();  // it stands on the stand
  while (mjsElement* key = mjs_firstElement(&spec, mjOBJ_KEY)) mjs_delete(&spec, key);
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_BODY); e; e = mjs_nextElement(&spec, e)) {
    mjs_asBody(e)->gravcomp = 1;
  }
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_GEOM); e; e = mjs_nextElement(&spec, e)) {
    mjs_asGeom(e)->contype = mjs_asGeom(e)->conaffinity = 0;  // the follower keeps it clear
  }
  for (const std::string& name : arm.file.actuators) {
    mjsActuator& servo = *mjs_asActuator(&find_arm_part(spec, mjOBJ_ACTUATOR, name));
    servo.biasprm[2] = -kFollowingLag * servo.gainprm[0];
  }
  for (const hand::ArmJoint& joint : arm.joints) {
    // It would show as a load that no contact explains, and the servo damps.
    mjs_asJoint(&find_arm_part(spec, mjOBJ_JOINT, joint.name))->damping[0] = 0;
  }
}

void attach(mjSpec& spec, mjsBody& parent, const Eigen::Isometry3d& T_parent_child,
            const mjsBody& child, const char* prefix) {
  mjsFrame* frame = mjs_addFrame(&parent, nullptr);
  write_pose(T_parent_child, frame->pos, frame->quat);
  if (!mjs_attach(frame->element, child.element, prefix, "")) {
    throw BadInput(fmt::format("the hand cannot be fixed to the arm: {}", mjs_getError(&spec)));
  }
}

}  // namespace

SpecHandle arm_with_hand(const hand::ArmDescription& arm, const hand::Description& hand,
                         const mjSpec& hand_spec) {
  const SpecHandle arm_spec = parse_model(arm.file.path, nullptr, "arm");
  prepare_arm(*arm_spec, arm);
  SpecHandle spec(mj_makeSpec());
  spec->compiler.balanceinertia = 1;
  attach(*spec, find_body(*spec, "world"), arm.T_world_stand, find_body(*arm_spec, arm.file.root),
         kArmPrefix);
  const std::string flange = std::string(kArmPrefix) + arm.file.flange;
  attach(*spec, find_body(*spec, flange), arm.T_flange_mount, find_body(hand_spec, hand.file.root),
         "");
  return spec;
}

}  // namespace palpate::simulation
