// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/hand_spec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "palpate/core/error.hpp"

namespace palpate::simulation {
namespace {

constexpr int kCollisionGroup = 3;  // of the hand's collision geoms in the MJCF

/// Where the base's origin lies in the palm's frame: the middle of a grasp, m.
const Eigen::Vector3d kGraspCenter(0.005, -0.045, 0.08);

double tip_length(int finger) { return finger == 0 ? 0.0275 : 0.0265; }

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

Eigen::Isometry3d pose_in(const mjSpec& spec, const std::string& root, const std::string& name) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const mjsBody* const end = &find_body(spec, root);
  for (mjsBody* body = &find_body(spec, name); body && body != end;
       body = mjs_getParent(body->element)) {
    T = pose3(body->pos, body->quat) * T;
  }
  return T;
}

void place_root(mjSpec& spec) {
  const std::string root = std::string(kRight) + "forearm";
  Eigen::Isometry3d T_base_palm = Eigen::Isometry3d::Identity();
  T_base_palm.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // x to +y, y to +z, z to +x
  T_base_palm.translation() = -(T_base_palm.linear() * kGraspCenter);
  const Eigen::Isometry3d T_forearm_palm = pose_in(spec, root, std::string(kRight) + "palm");
  mjsBody& forearm = find_body(spec, root);
  write_pose(T_base_palm * T_forearm_palm.inverse(), forearm.pos, forearm.quat);
}

mjsGeom& collision_geom(mjsBody& body, const std::string& name) {
  for (mjsElement* e = mjs_firstChild(&body, mjOBJ_GEOM, 0); e; e = mjs_nextChild(&body, e, 0)) {
    mjsGeom* geom = mjs_asGeom(e);
    if (geom->group == kCollisionGroup) return *geom;
  }
  throw BadInput(fmt::format("the hand's link {} has nothing to collide with", name));
}

void replace_tip(mjSpec& spec, int finger) {
  const std::string name = mjcf_distal(finger);
  mjsGeom& geom = collision_geom(find_body(spec, name), name);
  const double low = 0.0015;
  const double high = tip_length(finger) - kTipRadius;
  geom.type = mjGEOM_CAPSULE;
  mjs_setString(geom.meshname, "");
  mjs_setName(geom.element, mjcf_tip(finger).c_str());
  Eigen::Vector3d::Map(geom.size) << kTipRadius, 0.5 * (high - low), 0;
  Eigen::Vector3d::Map(geom.pos) << 0, 0, 0.5 * (high + low);
  Eigen::Vector4d::Map(geom.quat) << 1, 0, 0, 0;
}

}  // namespace

std::string mjcf_joint(std::string_view joint) { return fmt::format("{}{}", kRight, joint); }

std::string mjcf_actuator(std::string_view actuator) {
  return fmt::format("{}A_{}", kRight, actuator);
}

std::string mjcf_distal(int finger) {
  std::string name(hand::kFingerNames[static_cast<std::size_t>(finger)]);
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return fmt::format("{}{}distal", kRight, name);
}

std::string mjcf_tip(int finger) {
  return fmt::format("tip_{}", hand::kFingerNames[static_cast<std::size_t>(finger)]);
}

SpecHandle parse_shadow_hand(const std::filesystem::path& mjcf) {
  std::array<char, 512> message{};
  SpecHandle spec(mj_parseXML(mjcf.c_str(), nullptr, message.data(), message.size()));
  if (!spec) {
    throw BadInput(
        fmt::format("cannot read the hand {}: {}", mjcf.string(), one_line(message.data())));
  }
  place_root(*spec);
  for (int finger = 0; finger < hand::kFingers; ++finger) replace_tip(*spec, finger);
  return spec;
}

mjsBody& find_body(const mjSpec& spec, const std::string& name) {
  mjsBody* body = mjs_findBody(&spec, name.c_str());
  if (!body) throw BadInput(fmt::format("the hand's model has no body {}", name));
  return *body;
}

ModelHandle compile(mjSpec& spec) {
  ModelHandle model(mj_compile(&spec, nullptr));
  if (!model) {
    throw BadInput(
        fmt::format("the simulator refuses the model: {}", one_line(mjs_getError(&spec))));
  }
  return model;
}

int find_id(const mjModel& model, mjtObj type, const std::string& name) {
  const int id = mj_name2id(&model, type, name.c_str());
  if (id < 0) {
    throw BadInput(fmt::format("the hand's model has no {} {}", mju_type2Str(type), name));
  }
  return id;
}

}  // namespace palpate::simulation
