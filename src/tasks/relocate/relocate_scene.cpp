// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/relocate_scene.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>

#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/hand/warnings.hpp"
#include "simulation/world/mesh_geom.hpp"

namespace palpate::relocate {
namespace {

constexpr int kSubsteps = 5, kFastSubsteps = 3;
constexpr int kIterations = 20;
constexpr double kWristDamping = 0.05, kWristArmature = 0.001;
constexpr mjtSize kMemory = mjtSize{1} << 26;  // bytes, for all contacts of dozens of convex parts
constexpr const char* kObject = "relocated";
constexpr std::array kTipGeoms = {"C_thdistal", "C_ffdistal", "C_mfdistal", "C_rfdistal",
                                  "C_lfdistal"};

simulation::SpecHandle parse_hand() {
  const auto path = asset("adroit_hand/adroit_relocate.xml");
  std::array<char, 1000> error{};
  simulation::SpecHandle spec(mj_parseXML(path.c_str(), nullptr, error.data(), error.size()));
  if (!spec) {
    throw BadInput(fmt::format("{}: {}", path.string(), simulation::one_line(error.data())));
  }
  return spec;
}

int substeps(RelocateSolver solver) {
  return solver == RelocateSolver::fast ? kFastSubsteps : kSubsteps;
}

void set_solver(mjSpec& spec, RelocateSolver solver) {
  const bool faithful = solver == RelocateSolver::faithful;
  spec.memory = kMemory;
  spec.nconmax = -1;  // the hand's file limits contacts; a mug of many parts would lose its own
  spec.njmax = -1;
  spec.option.timestep = kControlStep / substeps(solver);
  spec.option.iterations = kIterations;
  spec.option.solver = faithful ? mjSOL_PGS : mjSOL_NEWTON;
  spec.option.noslip_iterations = faithful ? kIterations : 0;
  spec.option.cone = solver == RelocateSolver::fast ? mjCONE_PYRAMIDAL : mjCONE_ELLIPTIC;
  spec.option.disableflags |= mjDSBL_AUTORESET;  // a diverged episode must stay visible
}

/// Removes the ball that the hand's file relocates, and a tracker that nothing is fixed to.
void remove_strangers(mjSpec& spec) {
  for (const char* name : {"Object", "vive_tracker"}) {
    mjs_delete(&spec, simulation::find_body(spec, name).element);
  }
}

void widen_table(mjSpec& spec) {
  mjsBody& table = simulation::find_body(spec, "table");
  mjsElement* element = mjs_firstChild(&table, mjOBJ_GEOM, 0);
  if (!element) throw BadInput("the hand's model has a table without a top");
  mjsGeom& top = *mjs_asGeom(element);
  Eigen::Vector3d::Map(top.size) << 0.6, 0.6, 0.025;
  Eigen::Vector3d::Map(top.friction) << 1, 0.5, 0.01;
}

/// Gives the wrist's WRJ0 the damping (N m s/rad) and armature (kg m^2) of the published task's
/// hand (DexMV); the hand's file has ten times the damping and five times the armature.
void loosen_wrist(mjSpec& spec) {
  mjsElement* element = mjs_findElement(&spec, mjOBJ_JOINT, "WRJ0");
  if (!element) throw BadInput("the hand's model has no joint WRJ0");
  mjsJoint& joint = *mjs_asJoint(element);
  joint.damping[0] = kWristDamping;
  joint.armature = kWristArmature;
}

void set_object_contact(mjsGeom& geom) {
  Eigen::Vector3d::Map(geom.friction) << 1, 0.5, 0.01;
  geom.condim = 4;
  geom.margin = 0.003;
  geom.solref[0] = -6000;
  geom.solref[1] = -300;
  geom.rgba[0] = 0.85F;
  geom.rgba[1] = 0.35F;
  geom.rgba[2] = 0.2F;
}

void add_primitive(mjSpec& spec, mjsBody& body, const RelocatePrimitive& part) {
  mjsGeom* geom = mjs_addGeom(&body, mjs_getSpecDefault(&spec));
  geom->type = part.shape == RelocatePrimitive::Shape::box ? mjGEOM_BOX : mjGEOM_CYLINDER;
  Eigen::Vector3d::Map(geom->size) = part.half;
  simulation::write_pose(part.T_object_part, geom->pos, geom->quat);
  set_object_contact(*geom);
}

/// Adds a convex part in metres; the hand's file has meshes in millimetres by default.
void add_hull(mjSpec& spec, mjsBody& body, const std::string& name,
              const geometry::TriangleMesh& hull) {
  set_object_contact(simulation::add_mesh(spec, body, name, hull));
  mjsMesh* mesh = mjs_asMesh(mjs_findElement(&spec, mjOBJ_MESH, name.c_str()));
  Eigen::Vector3d::Map(mesh->scale).setOnes();
}

/// Whether the products of inertia are but rounding, as of a mesh of single precision.
bool is_diagonal(const Eigen::Matrix3d& inertia) {
  constexpr double kRounding = 1e-6;
  const Eigen::Matrix3d diagonal = inertia.diagonal().asDiagonal();
  return (inertia - diagonal).cwiseAbs().maxCoeff() <= kRounding * inertia.diagonal().maxCoeff();
}

void set_inertia(mjsBody& body, const RelocateObject& object, double scale) {
  body.explicitinertial = 1;
  body.mass = scale * object.mass;
  Eigen::Vector3d::Map(body.ipos) = object.center;
  const Eigen::Matrix3d I = scale * object.inertia;
  if (is_diagonal(I)) {
    Eigen::Vector3d::Map(body.inertia) = I.diagonal();
    return;
  }
  const std::array<double, 6> full = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  std::copy(full.begin(), full.end(), body.fullinertia);
}

void add_object(mjSpec& spec, const RelocateObject& object, double mass_scale) {
  mjsBody* body = mjs_addBody(mjs_findBody(&spec, "world"), nullptr);
  mjs_setName(body->element, kObject);
  body->pos[2] = object.start_height;
  const auto& q = object.start_rotation;
  Eigen::Vector4d::Map(body->quat) << q.w(), q.x(), q.y(), q.z();
  mjsJoint* joint = mjs_addJoint(body, mjs_getSpecDefault(&spec));
  mjs_setName(joint->element, kObject);
  joint->type = mjJNT_FREE;
  joint->limited = mjLIMITED_FALSE;
  joint->armature = 0.001;
  joint->frictionloss = 0.001;
  joint->damping[0] = 0;
  for (const auto& part : object.primitives) add_primitive(spec, *body, part);
  for (std::size_t i = 0; i < object.hulls.size(); ++i) {
    add_hull(spec, *body, fmt::format("hull{}", i), object.hulls[i]);
  }
  set_inertia(*body, object, mass_scale);
}

void scale_friction(mjModel& model, double scale) {
  for (int geom = 0; geom < model.ngeom; ++geom) model.geom_friction[3 * geom] *= scale;
}

void find_parts(RelocateScene& scene) {
  const mjModel& model = *scene.model;
  scene.object = mj_name2id(&model, mjOBJ_BODY, kObject);
  scene.palm = mj_name2id(&model, mjOBJ_SITE, "S_grasp");
  scene.target = mj_name2id(&model, mjOBJ_SITE, "target");
  const int arm = mj_name2id(&model, mjOBJ_BODY, "forearm");
  if (scene.palm < 0 || scene.target < 0 || arm < 0 || model.nu != kRelocateJoints ||
      model.nq != kRelocateJoints + 7) {
    throw BadInput(fmt::format(
        "the hand's model is not the Adroit hand: {} actuators, {} positions", model.nu, model.nq));
  }
  scene.object_joint = model.jnt_qposadr[mj_name2id(&model, mjOBJ_JOINT, kObject)];
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    scene.hand.push_back(model.body_rootid[body] == arm);
    scene.held.push_back(body == scene.object);
  }
  for (const char* tip : kTipGeoms) {
    scene.tips.push_back(simulation::find_id(model, mjOBJ_GEOM, tip));
  }
}

void check(const RelocatePhysics& physics) {
  for (const auto& [name, value] :
       {std::pair{"mass_scale", physics.mass_scale}, {"friction_scale", physics.friction_scale}}) {
    if (!(std::isfinite(value) && value > 0)) {
      throw BadInput(fmt::format("{} must be positive, not {}", name, value));
    }
  }
}

}  // namespace

RelocateScene compose_relocate_scene(const RelocateObject& object, const RelocatePhysics& physics,
                                     RelocateVisuals visuals) {
  check(physics);
  const simulation::SpecHandle spec = parse_hand();
  if (visuals == RelocateVisuals::none) mjs_discardVisual(spec.get(), nullptr);
  set_solver(*spec, physics.solver);
  remove_strangers(*spec);
  widen_table(*spec);
  loosen_wrist(*spec);
  add_object(*spec, object, physics.mass_scale);
  RelocateScene scene;
  scene.model.reset(mj_compile(spec.get(), nullptr));
  if (!scene.model) {
    throw BadInput(fmt::format("{} cannot be simulated: {}", object.name,
                               simulation::one_line(mjs_getError(spec.get()))));
  }
  scene.substeps = substeps(physics.solver);
  scale_friction(*scene.model, physics.friction_scale);
  find_parts(scene);
  return scene;
}

}  // namespace palpate::relocate
