// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/hand_alone.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/core/spelling.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

/// What an element of a model refers to by name.
struct Reference {
  mjtObj type;
  std::string name;
};

bool is_world(const std::string& body) { return body.empty() || body == "world"; }

std::vector<Reference> references_of(const mjsEquality& tie) {
  const std::string one = mjs_getString(tie.name1), other = mjs_getString(tie.name2);
  mjtObj type = mjOBJ_UNKNOWN;
  if (tie.type == mjEQ_JOINT) type = mjOBJ_JOINT;
  if (tie.type == mjEQ_TENDON) type = mjOBJ_TENDON;
  if (tie.type == mjEQ_CONNECT || tie.type == mjEQ_WELD) {
    type = tie.objtype == mjOBJ_SITE ? mjOBJ_SITE : mjOBJ_BODY;
  }
  if (type == mjOBJ_UNKNOWN) return {};
  if (other.empty()) return {{type, one}};
  return {{type, one}, {type, other}};
}

std::vector<Reference> references_of(const mjsActuator& actuator) {
  const std::string target = mjs_getString(actuator.target);
  switch (actuator.trntype) {
    case mjTRN_JOINT:
    case mjTRN_JOINTINPARENT:
      return {{mjOBJ_JOINT, target}};
    case mjTRN_TENDON:
      return {{mjOBJ_TENDON, target}};
    case mjTRN_BODY:
      return {{mjOBJ_BODY, target}};
    case mjTRN_SLIDERCRANK:
      return {{mjOBJ_SITE, target}, {mjOBJ_SITE, mjs_getString(actuator.slidersite)}};
    case mjTRN_SITE: {
      const std::string other = mjs_getString(actuator.refsite);
      if (other.empty()) return {{mjOBJ_SITE, target}};
      return {{mjOBJ_SITE, target}, {mjOBJ_SITE, other}};
    }
    default:
      return {};
  }
}

std::vector<Reference> references_of(mjsElement& element) {
  const auto followed = [](const mjString* body) -> std::vector<Reference> {
    if (!*mjs_getString(body)) return {};
    return {{mjOBJ_BODY, mjs_getString(body)}};
  };
  switch (element.elemtype) {
    case mjOBJ_EQUALITY:
      return references_of(*mjs_asEquality(&element));
    case mjOBJ_ACTUATOR:
      return references_of(*mjs_asActuator(&element));
    case mjOBJ_EXCLUDE:
      return {{mjOBJ_BODY, mjs_getString(mjs_asExclude(&element)->bodyname1)},
              {mjOBJ_BODY, mjs_getString(mjs_asExclude(&element)->bodyname2)}};
    case mjOBJ_PAIR:
      return {{mjOBJ_GEOM, mjs_getString(mjs_asPair(&element)->geomname1)},
              {mjOBJ_GEOM, mjs_getString(mjs_asPair(&element)->geomname2)}};
    case mjOBJ_CAMERA:
      return followed(mjs_asCamera(&element)->targetbody);
    case mjOBJ_LIGHT:
      return followed(mjs_asLight(&element)->targetbody);
    default:
      return {};
  }
}

bool has(const mjSpec& spec, const Reference& one) {
  return mjs_findElement(&spec, one.type, one.name.c_str()) != nullptr;
}

bool lacks_a_wrap(mjsElement& element) {
  if (element.elemtype != mjOBJ_TENDON) return false;
  const mjsTendon& tendon = *mjs_asTendon(&element);
  for (int i = 0; i < mjs_getWrapNum(&tendon); ++i) {
    const mjsWrap* wrap = mjs_getWrap(&tendon, i);
    if (wrap->type != mjWRAP_PULLEY && !mjs_getWrapTarget(wrap)) return true;
  }
  return false;
}

/// The mount carries the hand: what ties a body to the world counts as tied to what is gone.
bool is_tied_to_world(mjsElement& element) {
  if (element.elemtype != mjOBJ_EQUALITY) return false;
  const mjsEquality& tie = *mjs_asEquality(&element);
  if (tie.type != mjEQ_CONNECT && tie.type != mjEQ_WELD) return false;
  return tie.objtype != mjOBJ_SITE &&
         (is_world(mjs_getString(tie.name1)) || is_world(mjs_getString(tie.name2)));
}

bool is_dangling(const mjSpec& spec, mjsElement& element) {
  return lacks_a_wrap(element) || is_tied_to_world(element) ||
         !std::ranges::all_of(references_of(element),
                              [&](const Reference& one) { return has(spec, one); });
}

/// Kinds of elements that refer to others by name. Tendons come before what refers to them.
constexpr std::array<mjtObj, 7> kReferring = {mjOBJ_TENDON,  mjOBJ_EQUALITY, mjOBJ_ACTUATOR,
                                              mjOBJ_EXCLUDE, mjOBJ_PAIR,     mjOBJ_CAMERA,
                                              mjOBJ_LIGHT};

/// Calls a function with each of a model's elements that refer to others; it may remove them.
template <class Function>
void for_each_referring(mjSpec& spec, const Function& function) {
  for (const mjtObj type : kReferring) {
    for (mjsElement* e = mjs_firstElement(&spec, type); e;) {
      mjsElement* const next = mjs_nextElement(&spec, e);
      function(*e);
      e = next;
    }
  }
}

/// Removes what refers to what is no longer there.
void remove_dangling(mjSpec& spec) {
  for_each_referring(spec, [&](mjsElement& element) {
    if (is_dangling(spec, element)) mjs_delete(&spec, &element);
  });
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

/// "the equality 'tie'", or without a name "an equality".
std::string described(mjsElement& element) {
  const std::string kind = mju_type2Str(element.elemtype);
  const std::string name = mjs_getString(mjs_getName(&element));
  if (!name.empty()) return fmt::format("the {} '{}'", kind, name);
  return fmt::format("{} {}", kind.find_first_of("aeiou") == 0 ? "an" : "a", kind);
}

}  // namespace

void refuse_broken_references(mjSpec& spec) {
  for_each_referring(spec, [&](mjsElement& element) {
    if (lacks_a_wrap(element)) {
      throw BadInput(described(element) + " goes over a joint, site or geom that the file lacks");
    }
    for (const Reference& one : references_of(element)) {
      if (has(spec, one) || (one.type == mjOBJ_BODY && is_world(one.name))) continue;
      throw BadInput(fmt::format("{} refers to the {} '{}', which the file lacks{}",
                                 described(element), mju_type2Str(one.type), one.name,
                                 did_you_mean(one.name, names_of(spec, one.type))));
    }
  });
}

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
