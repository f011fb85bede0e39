// SPDX-License-Identifier: Apache-2.0
#include "simulation/rendering/drawn_scene.hpp"

#include <fmt/format.h>

#include <string>

#include "palpate/core/error.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/world/mesh_geom.hpp"

namespace palpate::simulation {
namespace {

constexpr double kTableThickness = 0.02;  // m
// The names of what is not of the hand's file (kOwnPrefix).
constexpr const char* kTable = "palpate:table";
constexpr const char* kObject = "palpate:object";

using Color = Eigen::Vector3f;

const Color kObjectColor(0.93f, 0.46f, 0.16f);
const Color kHandColor(0.42f, 0.45f, 0.50f);
const Color kTableColor(0.80f, 0.74f, 0.66f);
const Color kSkyTop(0.96f, 0.97f, 0.98f);
const Color kSkyBottom(0.62f, 0.69f, 0.77f);

void set(float* rgb, const Color& color) { Eigen::Vector3f::Map(rgb) = color; }
Color gray(float value) { return Color::Constant(value); }

void set_quality(mjVisual& visual, int width, int height) {
  visual.global.offwidth = width;
  visual.global.offheight = height;
  visual.global.fovy = 30;
  visual.quality.offsamples = 8;
  visual.quality.shadowsize = 8192;
  visual.quality.numslices = 200;  // of the round table
  visual.map.znear = 0.02f;
  visual.map.shadowclip = 0.6f;
  set(visual.headlight.ambient, gray(0.36f));
  set(visual.headlight.diffuse, gray(0.2f));
  set(visual.headlight.specular, gray(0.1f));
}

void add_sky(mjSpec& spec) {
  mjsTexture* sky = mjs_addTexture(&spec, mjs_getSpecDefault(&spec));
  set_name(sky->element, "palpate:sky");
  sky->type = mjTEXTURE_SKYBOX;
  sky->builtin = mjBUILTIN_GRADIENT;
  sky->width = 512;
  sky->height = 512;
  Eigen::Vector3d::Map(sky->rgb1) = kSkyTop.cast<double>();
  Eigen::Vector3d::Map(sky->rgb2) = kSkyBottom.cast<double>();
}

mjsMaterial& add_material(mjSpec& spec, const char* name, const Color& color) {
  mjsMaterial* material = mjs_addMaterial(&spec, mjs_getSpecDefault(&spec));
  set_name(material->element, name);
  set(material->rgba, color);
  return *material;
}

void add_sun(mjsBody& world, const Eigen::Vector3d& from, float brightness, bool shadow) {
  mjsLight* light = mjs_addLight(&world, nullptr);
  light->type = mjLIGHT_DIRECTIONAL;
  Eigen::Vector3d::Map(light->pos) = from;
  Eigen::Vector3d::Map(light->dir) = -from.normalized();
  light->castshadow = shadow;
  set(light->diffuse, gray(brightness));
  set(light->specular, gray(0.5f * brightness));
}

void add_surroundings(mjSpec& spec) {
  add_sky(spec);
  mjsBody& world = *mjs_findBody(&spec, "world");
  mjsGeom* table = mjs_addGeom(&world, mjs_getSpecDefault(&spec));
  table->type = mjGEOM_CYLINDER;
  Eigen::Vector3d::Map(table->size) << 0.55, kTableThickness / 2, 0;
  table->pos[2] = -kTableThickness / 2;
  mjsMaterial& material = add_material(spec, kTable, kTableColor);
  material.specular = 0;
  mjs_setString(table->material, kTable);
  add_sun(world, {0.5, 0.5, 1.6}, 0.42f, true);
  add_sun(world, {0.9, -1.0, 0.6}, 0.3f, false);
  add_sun(world, {1.0, 0.8, 0.3}, 0.3f, false);
}

/// The MJCF's plastic is so dark that its shape would not show.
void brighten_hand(mjSpec& spec) {
  mjsMaterial* plastic = mjs_asMaterial(mjs_findElement(&spec, mjOBJ_MATERIAL, "black"));
  if (plastic) set(plastic->rgba, kHandColor);
}

void add_free_body(mjsBody& body) {
  mjsJoint* joint = mjs_addFreeJoint(&body);
  joint->align = mjALIGNFREE_FALSE;
}

void add_object(mjSpec& spec, const geometry::TriangleMesh& mesh) {
  mjsBody* body = mjs_addBody(mjs_findBody(&spec, "world"), nullptr);
  set_name(body->element, kObject);
  body->explicitinertial = 1;  // any: it is never simulated
  body->mass = 1;
  Eigen::Vector3d::Map(body->inertia).setOnes();
  add_free_body(*body);
  mjsMaterial& material = add_material(spec, kObject, kObjectColor);
  material.specular = 0.5f;
  material.shininess = 0.6f;
  mjs_setString(add_mesh(spec, *body, kObject, mesh).material, kObject);
}

int position_of(const mjModel& model, const std::string& body) {
  return model.jnt_qposadr[model.body_jntadr[find_id(model, mjOBJ_BODY, body)]];
}

}  // namespace

DrawnScene compose_drawn_scene(const hand::Description& hand, const geometry::KnownObject& object,
                               int width, int height) {
  const SpecHandle spec = parse_hand(hand);
  mjsBody& root = find_body(*spec, hand.file.root);
  DrawnScene scene;
  scene.T_mount_hand = pose3(root.pos, root.quat);
  add_free_body(root);
  add_surroundings(*spec);
  add_object(*spec, object.mesh);
  spec->stat.extent = 1;  // m: what the distances in mjVisual are relative to
  set_quality(spec->visual, width, height);
  brighten_hand(*spec);
  scene.model = compile(*spec);
  const mjModel& model = *scene.model;
  for (const hand::Joint& joint : hand.joints) {
    scene.joint_positions.push_back(
        model.jnt_qposadr[find_id(model, mjOBJ_JOINT, file_joint(hand, joint.name))]);
  }
  scene.hand_position = position_of(model, hand.file.root);
  scene.object_position = position_of(model, kObject);
  scene.object_geom = find_id(model, mjOBJ_GEOM, kObject);
  return scene;
}

void pose_scene(const DrawnScene& scene, const DrawnState& state, mjData& data) {
  const Eigen::Isometry3d T_world_hand = state.mount.pose() * scene.T_mount_hand;
  if (!T_world_hand.matrix().allFinite() || !state.T_world_object.matrix().allFinite() ||
      !state.joints.allFinite()) {
    const Eigen::Vector3d& object = state.T_world_object.translation();
    const Eigen::Vector3d hand = T_world_hand.translation();
    throw BadInput(fmt::format(
        "cannot draw what is not finite: object at ({}, {}, {}), hand at ({}, {}, {}), "
        "joints' sum {}",
        object.x(), object.y(), object.z(), hand.x(), hand.y(), hand.z(), state.joints.sum()));
  }
  mjtNum* const hand = data.qpos + scene.hand_position;
  mjtNum* const object = data.qpos + scene.object_position;
  write_pose(T_world_hand, hand, hand + 3);
  write_pose(state.T_world_object, object, object + 3);
  for (std::size_t i = 0; i < scene.joint_positions.size(); ++i) {
    data.qpos[scene.joint_positions[i]] = state.joints[static_cast<int>(i)];
  }
  mj_kinematics(scene.model.get(), &data);
  mj_comPos(scene.model.get(), &data);
  mj_camlight(scene.model.get(), &data);
}

}  // namespace palpate::simulation
