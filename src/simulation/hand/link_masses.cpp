// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/link_masses.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"

namespace palpate::simulation {
namespace {

constexpr double kLeastInertia = 1e-7;  // kg m^2

/// Whether a body has a mass, of its own or of its shapes.
bool has_mass(mjsBody& body) {
  if (body.explicitinertial) return body.mass > 0;
  for (mjsElement* e = mjs_firstChild(&body, mjOBJ_GEOM, 0); e; e = mjs_nextChild(&body, e, 0)) {
    const mjsGeom& geom = *mjs_asGeom(e);
    if (std::isfinite(geom.mass) ? geom.mass != 0 : geom.density != 0) return true;
  }
  return false;
}

/// Whether a body, or what is fixed to it, has a mass.
bool moves_mass(mjsBody& body) {
  if (has_mass(body)) return true;
  for (mjsElement* e = mjs_firstChild(&body, mjOBJ_BODY, 0); e; e = mjs_nextChild(&body, e, 0)) {
    mjsBody& child = *mjs_asBody(e);
    if (!mjs_firstChild(&child, mjOBJ_JOINT, 0) && moves_mass(child)) return true;
  }
  return false;
}

/// Whether a body has joints, or may be a hand's root, which the mount moves.
bool moves(const mjSpec& spec, const mjsBody& body) {
  const mjsBody* const above = mjs_getParent(body.element);
  return mjs_firstChild(&body, mjOBJ_JOINT, 0) ||
         (!body.mocap && above && above == mjs_findBody(&spec, "world"));
}

}  // namespace

void apply_inertia_rules(mjSpec& spec) {
  const bool of_geoms = spec.compiler.inertiafromgeom == mjINERTIAFROMGEOM_TRUE;
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_BODY); e; e = mjs_nextElement(&spec, e)) {
    if (of_geoms) mjs_asBody(e)->explicitinertial = 0;
  }
  spec.compiler.inertiafromgeom = mjINERTIAFROMGEOM_AUTO;
  spec.compiler.settotalmass = -1;
  spec.stat.meaninertia = std::numeric_limits<double>::quiet_NaN();
}

void refuse_negative_masses(mjSpec& spec) {
  const auto refuse = [](const char* what, mjsBody& body, double mass) {
    throw BadInput(fmt::format("{} link {} has a mass of {} kg", what,
                               mjs_getString(mjs_getName(body.element)), mass));
  };
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_BODY); e; e = mjs_nextElement(&spec, e)) {
    mjsBody& body = *mjs_asBody(e);
    if (body.explicitinertial && body.mass < 0) refuse("the", body, body.mass);
    for (mjsElement* g = mjs_firstChild(&body, mjOBJ_GEOM, 0); g; g = mjs_nextChild(&body, g, 0)) {
      if (mjs_asGeom(g)->mass < 0) refuse("a shape of the", body, mjs_asGeom(g)->mass);
    }
  }
}

std::vector<std::string> give_masses(mjSpec& spec) {
  std::vector<std::string> names;
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_BODY); e; e = mjs_nextElement(&spec, e)) {
    mjsBody& body = *mjs_asBody(e);
    if (!moves(spec, body) || moves_mass(body)) continue;
    body.explicitinertial = 1;
    body.mass = kLeastMass;
    Eigen::Vector3d::Map(body.inertia).setConstant(kLeastInertia);
    Eigen::Vector3d::Map(body.ipos).setZero();
    Eigen::Vector4d::Map(body.iquat) << 1, 0, 0, 0;
    body.ialt.type = mjORIENTATION_QUAT;
    body.fullinertia[0] = std::numeric_limits<double>::quiet_NaN();
    names.emplace_back(mjs_getString(mjs_getName(e)));
  }
  return names;
}

}  // namespace palpate::simulation
