// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/hand_alone.hpp"

#include <array>
#include <cmath>
#include <string_view>

#include "palpate/core/error.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

bool has(const mjSpec& spec, mjtObj type, const mjString* name) {
  return mjs_findElement(&spec, type, mjs_getString(name)) != nullptr;
}

bool is_world(const mjString* body) {
  const std::string_view name = mjs_getString(body);
  return name.empty() || name == "world";
}

/// The mount carries the hand: ties to the world count as ties to what is gone.
bool is_dangling(const mjSpec& spec, const mjsEquality& tie) {
  const bool one_only = std::string_view(mjs_getString(tie.name2)).empty();
  if (tie.type == mjEQ_JOINT || tie.type == mjEQ_TENDON) {
    const mjtObj type = tie.type == mjEQ_JOINT ? mjOBJ_JOINT : mjOBJ_TENDON;
    return !has(spec, type, tie.name1) || !(one_only || has(spec, type, tie.name2));
  }
  if (tie.type != mjEQ_CONNECT && tie.type != mjEQ_WELD) return false;
  const mjtObj type = tie.objtype == mjOBJ_SITE ? mjOBJ_SITE : mjOBJ_BODY;
  if (type == mjOBJ_BODY && (is_world(tie.name1) || is_world(tie.name2))) return true;
  return !has(spec, type, tie.name1) || !has(spec, type, tie.name2);
}

bool is_dangling(const mjSpec& spec, const mjsActuator& actuator) {
  const auto lacks = [&](mjtObj type, const mjString* name) { return !has(spec, type, name); };
  switch (actuator.trntype) {
    case mjTRN_JOINT:
    case mjTRN_JOINTINPARENT:
      return lacks(mjOBJ_JOINT, actuator.target);
    case mjTRN_TENDON:
      return lacks(mjOBJ_TENDON, actuator.target);
    case mjTRN_BODY:
      return lacks(mjOBJ_BODY, actuator.target);
    case mjTRN_SLIDERCRANK:
      return lacks(mjOBJ_SITE, actuator.target) || lacks(mjOBJ_SITE, actuator.slidersite);
    case mjTRN_SITE:
      return lacks(mjOBJ_SITE, actuator.target) ||
             (*mjs_getString(actuator.refsite) && lacks(mjOBJ_SITE, actuator.refsite));
    default:
      return false;
  }
}

bool is_dangling(const mjsTendon& tendon) {
  for (int i = 0; i < mjs_getWrapNum(&tendon); ++i) {
    const mjsWrap* wrap = mjs_getWrap(&tendon, i);
    if (wrap->type != mjWRAP_PULLEY && !mjs_getWrapTarget(wrap)) return true;
  }
  return false;
}

bool targets_nothing(const mjSpec& spec, const mjString* body) {
  return *mjs_getString(body) && !has(spec, mjOBJ_BODY, body);
}

bool is_dangling(const mjSpec& spec, mjsElement& element) {
  switch (element.elemtype) {
    case mjOBJ_EQUALITY:
      return is_dangling(spec, *mjs_asEquality(&element));
    case mjOBJ_ACTUATOR:
      return is_dangling(spec, *mjs_asActuator(&element));
    case mjOBJ_TENDON:
      return is_dangling(*mjs_asTendon(&element));
    case mjOBJ_EXCLUDE:
      return !has(spec, mjOBJ_BODY, mjs_asExclude(&element)->bodyname1) ||
             !has(spec, mjOBJ_BODY, mjs_asExclude(&element)->bodyname2);
    case mjOBJ_PAIR:
      return !has(spec, mjOBJ_GEOM, mjs_asPair(&element)->geomname1) ||
             !has(spec, mjOBJ_GEOM, mjs_asPair(&element)->geomname2);
    case mjOBJ_CAMERA:
      return targets_nothing(spec, mjs_asCamera(&element)->targetbody);
    case mjOBJ_LIGHT:
      return targets_nothing(spec, mjs_asLight(&element)->targetbody);
    default:
      return false;
  }
}

/// Removes what refers to what is no longer there. Tendons come before what refers to them.
void remove_dangling(mjSpec& spec) {
  for (const mjtObj type : {mjOBJ_TENDON, mjOBJ_EQUALITY, mjOBJ_ACTUATOR, mjOBJ_EXCLUDE, mjOBJ_PAIR,
                            mjOBJ_CAMERA, mjOBJ_LIGHT}) {
    for (mjsElement* e = mjs_firstElement(&spec, type); e;) {
      mjsElement* const next = mjs_nextElement(&spec, e);
      if (is_dangling(spec, *e)) mjs_delete(&spec, e);
      e = next;
    }
  }
}

void remove_children(mjSpec& spec, mjsBody& body, mjtObj type, const mjsElement* but = nullptr) {
  for (mjsElement* e = mjs_firstChild(&body, type, 0); e;) {
    mjsElement* const next = mjs_nextChild(&body, e, 0);
    if (e != but) mjs_delete(&spec, e);
    e = next;
  }
}

/// Hands its children to its parent.
void dissolve(mjSpec& spec, mjsBody* body) {
  remove_children(spec, *body, mjOBJ_JOINT);
  mjs_bodyToFrame(&body);
}

/// The pose of a frame in the frame around it.
Eigen::Isometry3d pose_of(const mjsFrame& frame) {
  const mjsCompiler& compiler = *mjs_getCompiler(frame.element);
  std::array<double, 4> quat{};
  std::copy(std::begin(frame.quat), std::end(frame.quat), quat.begin());
  const std::string sequence(std::begin(compiler.eulerseq), std::end(compiler.eulerseq));
  mjs_resolveOrientation(quat.data(), compiler.degree, sequence.c_str(), &frame.alt);
  return pose3(frame.pos, quat.data());
}

}  // namespace

void keep_hand_only(mjSpec& spec, const std::string& root) {
  mjsBody& body = find_body(spec, root);
  mjsBody* const world = mjs_findBody(&spec, "world");
  if (&body == world) throw BadInput("root = 'world' is no body of a hand: name its first body");
  remove_children(spec, body, mjOBJ_JOINT);
  for (mjsBody* above = mjs_getParent(body.element); above != world;
       above = mjs_getParent(body.element)) {
    dissolve(spec, above);
  }
  for (const mjtObj type : {mjOBJ_BODY, mjOBJ_GEOM, mjOBJ_SITE, mjOBJ_CAMERA}) {
    remove_children(spec, *world, type, body.element);
  }
  leave_frames(*world, *body.element);
  remove_dangling(spec);
}

void remove_tendons(mjSpec& spec) {
  while (mjsElement* tendon = mjs_firstElement(&spec, mjOBJ_TENDON)) mjs_delete(&spec, tendon);
  remove_dangling(spec);
}

void leave_frames(mjsBody& parent, mjsElement& element) {
  if (mjs_getFrame(&element)) mjs_setFrame(&element, mjs_addFrame(&parent, nullptr));
}

Eigen::Vector3d middle_in_body(const mjsGeom& geom) {
  const bool has_ends = std::isfinite(geom.fromto[0]);
  Eigen::Vector3d p = has_ends
                          ? Eigen::Vector3d(0.5 * (vector3(geom.fromto) + vector3(geom.fromto + 3)))
                          : vector3(geom.pos);
  for (const mjsFrame* frame = mjs_getFrame(geom.element); frame;
       frame = mjs_getFrame(frame->element)) {
    p = pose_of(*frame) * p;
  }
  return p;
}

}  // namespace palpate::simulation
