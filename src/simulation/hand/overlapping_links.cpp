// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/overlapping_links.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "simulation/hand/anatomy.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/hand/model_checks.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {
namespace {

constexpr double kOverlap = 0.0005;  // m

using BodyPair = std::pair<int, int>;

std::set<BodyPair> overlaps_at(const mjModel& model, mjData& data, const hand::Description& hand,
                               const hand::JointVector& joints) {
  for (int i = 0; i < hand.joint_count(); ++i) {
    const int id = find_id(model, mjOBJ_JOINT, hand.joints[static_cast<std::size_t>(i)].name);
    data.qpos[model.jnt_qposadr[id]] = joints[i];
  }
  mj_kinematics(&model, &data);
  mj_comPos(&model, &data);
  mj_collision(&model, &data);
  std::set<BodyPair> pairs;
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.dist > -kOverlap) continue;
    pairs.insert(
        std::minmax({model.geom_bodyid[contact.geom[0]], model.geom_bodyid[contact.geom[1]]}));
  }
  return pairs;
}

}  // namespace

bool let_all_collide(mjSpec& spec) {
  bool changed = false;
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_GEOM); e; e = mjs_nextElement(&spec, e)) {
    mjsGeom& geom = *mjs_asGeom(e);
    if ((geom.contype == 0 && geom.conaffinity == 0) || (geom.contype & geom.conaffinity & 1) != 0)
      continue;
    geom.contype = geom.conaffinity = 1;
    changed = true;
  }
  return changed;
}

std::vector<std::pair<std::string, std::string>> overlapping_links(
    const mjModel& model, const hand::Description& hand,
    const std::vector<hand::JointVector>& postures) {
  const DataHandle data = make_data(model);
  std::set<BodyPair> always = overlaps_at(model, *data, hand, postures.front());
  for (const hand::JointVector& joints : postures) {
    const auto now = overlaps_at(model, *data, hand, joints);
    std::erase_if(always, [&](const BodyPair& pair) { return !now.contains(pair); });
  }
  std::vector<std::pair<std::string, std::string>> names;
  for (const auto& [one, other] : always) {
    names.emplace_back(model_name(model, mjOBJ_BODY, one), model_name(model, mjOBJ_BODY, other));
  }
  return names;
}

std::string first_of(const std::vector<std::pair<std::string, std::string>>& pairs) {
  std::vector<std::string> texts;
  for (const auto& [one, other] : pairs) texts.push_back(fmt::format("{} and {}", one, other));
  return first_of(texts);
}

}  // namespace palpate::simulation
