// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "palpate/core/error.hpp"
#include "simulation/contact/exact_contact.hpp"
#include "simulation/contact/table_contact.hpp"
#include "simulation/hand/arm_spec.hpp"
#include "simulation/hand/hand_joints.hpp"
#include "simulation/hand/hand_model.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/world/mesh_geom.hpp"

namespace palpate::simulation {
namespace {

constexpr int kContactDimensions = 4;  // normal, two of sliding, one of spinning
constexpr double kSpinFriction = 0.01;
constexpr double kRollFriction = 0.0002;

// Between table and object, m: spinning, and rolling. A round body comes to rest on a real table
// because the table gives way a little in front of it.
constexpr std::array<double, 2> kTableRest = {0.002, 0.0005};

// Softer than the tightest spring the time step allows, so that a flat contact does not chatter.
constexpr double kContactTime = 0.007;  // s
constexpr std::array<double, 5> kObjectImpedance = {0.9, 0.95, 0.001, 0.5, 2};

// Who meets whom: type of one and affinity of the other must share a bit. Fingertips meet the
// object's true surface, all else its convex parts. With the table it makes a pair of its own.
struct ContactBits {
  int type, affinity;
};
constexpr ContactBits kSolidBits = {1, 7};
constexpr ContactBits kTableBits = {1, 5};  // of a table that meets the hull
constexpr ContactBits kPartBits = {2, 2};
constexpr ContactBits kTipBits = {4, 12};
constexpr ContactBits kSurfaceBits = {8, 0};
constexpr ContactBits kNoBits = {0, 0};

void set_bits(mjsGeom& geom, ContactBits bits) {
  geom.contype = bits.type;
  geom.conaffinity = bits.affinity;
}

// The names of what is not of the hand's file (kOwnPrefix).
constexpr const char* kTable = "palpate:table";
constexpr const char* kObject = "palpate:object";
constexpr const char* kPart = "palpate:part_";  // and a number
constexpr const char* kSurface = "palpate:surface";
constexpr const char* kSecond = "palpate:second_object";
constexpr double kSecondMass = 0.2;                   // kg
constexpr const char* kFixture = "palpate:fixture_";  // and a number

struct MountAxis {
  const char* name;
  mjtJoint type;
  int axis;
};
constexpr std::array<MountAxis, 6> kMountAxes = {{{"palpate:mount_x", mjJNT_SLIDE, 0},
                                                  {"palpate:mount_y", mjJNT_SLIDE, 1},
                                                  {"palpate:mount_z", mjJNT_SLIDE, 2},
                                                  {"palpate:mount_yaw", mjJNT_HINGE, 2},
                                                  {"palpate:mount_pitch", mjJNT_HINGE, 1},
                                                  {"palpate:mount_roll", mjJNT_HINGE, 0}}};

struct Servo {
  double stiffness, damping, limit;
};
constexpr Servo kSlideServo = {4000, 253, 200};  // N/m, N s/m, N
constexpr Servo kHingeServo = {200, 12.6, 50};   // N m/rad, N m s/rad, N m
/// Of the hinges' rotors. Without it the inertia is singular at a pitch of 90 deg, where yaw and
/// roll turn about one axis, and what the hand holds is thrown out of it there.
constexpr double kHingeInertia = 0.01;  // kg m^2

void require_positive(const char* name, double value) {
  if (!(std::isfinite(value) && value > 0)) {
    throw BadInput(fmt::format("{} must be positive, not {}", name, value));
  }
}

void check(const WorldOptions& options) {
  require_positive("time_step", options.time_step);
  require_positive("hand_friction", options.hand_friction);
  require_positive("table_friction", options.table_friction);
  require_positive("stiffness_scale", options.stiffness_scale);
  const double steps = hand::kTick / options.time_step;
  if (steps < 1 || std::abs(steps - std::round(steps)) > 1e-9) {
    throw BadInput(
        fmt::format("time_step must divide {} s, not {}", hand::kTick, options.time_step));
  }
}

void set_solver(mjSpec& spec, const WorldOptions& options) {
  spec.option.timestep = options.time_step;
  spec.option.integrator = mjINT_IMPLICITFAST;
  spec.option.solver = mjSOL_NEWTON;
  spec.option.cone = mjCONE_ELLIPTIC;  // with pyramids objects slip out of the hand
  spec.option.impratio = 10;
  spec.option.noslip_iterations = 5;
  spec.nuser_geom = kTipHullUserData + 1;
  spec.option.disableflags |= mjDSBL_AUTORESET;  // a diverged world must stay visible
}

/// @param exact  it meets the hull of the object's mesh (add_resting_geom) instead of the parts
void add_table(mjSpec& spec, double friction, bool exact, const Eigen::Isometry3d& T_world_table) {
  mjsGeom* table = mjs_addGeom(mjs_findBody(&spec, "world"), nullptr);
  set_name(table->element, kTable);
  table->type = mjGEOM_PLANE;
  write_pose(T_world_table, table->pos, table->quat);
  Eigen::Vector3d::Map(table->size) << 1, 1, 0.1;
  Eigen::Vector3d::Map(table->friction) << friction, 0.005, 0.0001;
  table->condim = 3;
  table->priority = 1;
  set_bits(*table, exact ? kTableBits : kSolidBits);
}

void add_fixture(mjSpec& spec, const planning::Fixture& fixture, double friction,
                 const Eigen::Isometry3d& T_world_table) {
  mjsBody* world = mjs_findBody(&spec, "world");
  int number = 0;
  for (const planning::FixtureBox& box : fixture) {
    for (const double half : box.half_extents) require_positive("a fixture's half extent", half);
    mjsGeom* geom = mjs_addGeom(world, nullptr);
    set_name(geom->element, fmt::format("{}{}", kFixture, number++));
    geom->type = mjGEOM_BOX;
    Eigen::Vector3d::Map(geom->size) = box.half_extents;
    write_pose(T_world_table * box.T_world_box, geom->pos, geom->quat);
    Eigen::Vector3d::Map(geom->friction) << friction, 0.005, 0.0001;
    geom->condim = 3;
    geom->priority = 1;
    geom->solref[0] = kContactTime;
    set_bits(*geom, kSolidBits);
  }
}

void add_mount_joint(mjSpec& spec, mjsBody& root, const MountAxis& axis) {
  const Eigen::Isometry3d T_root_mount = pose3(root.pos, root.quat).inverse();
  mjsJoint* joint = mjs_addJoint(&root, mjs_getSpecDefault(&spec));
  set_name(joint->element, axis.name);
  joint->type = axis.type;
  Eigen::Vector3d::Map(joint->axis) = T_root_mount.linear().col(axis.axis);
  Eigen::Vector3d::Map(joint->pos) = T_root_mount.translation();
  if (axis.type == mjJNT_HINGE) joint->armature = kHingeInertia;
}

void add_mount_servo(mjSpec& spec, const MountAxis& axis) {
  const Servo& servo = axis.type == mjJNT_SLIDE ? kSlideServo : kHingeServo;
  mjsActuator* actuator = mjs_addActuator(&spec, mjs_getSpecDefault(&spec));
  set_name(actuator->element, axis.name);
  mjs_setString(actuator->target, axis.name);
  actuator->trntype = mjTRN_JOINT;
  // Damped by the servo, not the joint: joint damping would show up as a contact force.
  double damping = servo.damping;
  mjs_setToPosition(actuator, servo.stiffness, &damping, nullptr, nullptr, 0);
  actuator->forcelimited = mjLIMITED_TRUE;
  actuator->forcerange[0] = -servo.limit;
  actuator->forcerange[1] = servo.limit;
}

void add_mount(mjSpec& spec, const hand::Description& hand) {
  mjsBody& root = find_body(spec, hand.file.root);
  for (const MountAxis& axis : kMountAxes) {
    add_mount_joint(spec, root, axis);
    add_mount_servo(spec, axis);
  }
}

void set_friction(mjsGeom& geom, double friction) {
  Eigen::Vector3d::Map(geom.friction) << friction, kSpinFriction, kRollFriction;
  geom.condim = kContactDimensions;
}

/// A file's own contacts may be too stiff for the time step.
void soften(mjsGeom& geom) {
  geom.solref[0] = kContactTime;
  geom.solref[1] = 1;
  std::copy(kObjectImpedance.begin(), kObjectImpedance.end(), geom.solimp);
  geom.margin = geom.gap = 0;
  geom.priority = 0;
}

void prepare_hand(mjSpec& spec, const hand::Description& hand, const WorldOptions& options) {
  mjs_discardVisual(&spec, nullptr);
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_GEOM); e; e = mjs_nextElement(&spec, e)) {
    set_friction(*mjs_asGeom(e), options.hand_friction);
    set_bits(*mjs_asGeom(e), kSolidBits);
    if (!hand.file.own_servos) soften(*mjs_asGeom(e));
  }
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    const std::string name = tip_geom(hand, finger);
    mjsGeom& tip = *mjs_asGeom(mjs_findElement(&spec, mjOBJ_GEOM, name.c_str()));
    tip.solref[0] = kContactTime;
    if (options.exact_tips) set_bits(tip, kTipBits);
  }
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_BODY); e; e = mjs_nextElement(&spec, e)) {
    mjs_asBody(e)->gravcomp = 1;
  }
  prepare_joints(spec, hand, options.stiffness_scale);
}

mjsGeom& add_solid(mjSpec& spec, mjsBody& body, const std::string& name,
                   const geometry::TriangleMesh& mesh) {
  mjsGeom& geom = add_mesh(spec, body, name, mesh);
  geom.solref[0] = kContactTime;
  std::copy(kObjectImpedance.begin(), kObjectImpedance.end(), geom.solimp);
  return geom;
}

mjsBody& add_object_body(mjSpec& spec, const geometry::KnownObject& object) {
  mjsBody* body = mjs_addBody(mjs_findBody(&spec, "world"), nullptr);
  set_name(body->element, kObject);
  const Eigen::Matrix3d& I = object.mass_properties.inertia;
  const std::array<double, 6> inertia = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  body->explicitinertial = 1;
  body->mass = object.mass;
  Eigen::Vector3d::Map(body->ipos) = object.mass_properties.centroid;
  std::copy(inertia.begin(), inertia.end(), body->fullinertia);
  mjsJoint* joint = mjs_addFreeJoint(body);
  joint->align = mjALIGNFREE_FALSE;
  return *body;
}

std::string resting_geom(int share) { return fmt::format("palpate:rest_{}", share); }

/// What the table touches: nothing but the hull of the object's mesh.
void add_resting_geom(mjSpec& spec, mjsBody& body, int share, double friction) {
  mjsGeom* geom = mjs_addGeom(&body, mjs_getSpecDefault(&spec));
  set_name(geom->element, resting_geom(share));
  mjs_setString(geom->meshname, kSurface);
  geom->type = mjGEOM_MESH;
  set_bits(*geom, kNoBits);
  mjsPair* pair = mjs_addPair(&spec, nullptr);
  mjs_setString(pair->geomname1, kTable);
  mjs_setString(pair->geomname2, resting_geom(share).c_str());
  pair->condim = 6;
  pair->solref[0] = kContactTime;
  std::copy(kObjectImpedance.begin(), kObjectImpedance.end(), pair->solimp);
  const auto [spin, roll] = kTableRest;
  const std::array<double, 5> frictions = {friction, friction, spin, roll, roll};
  std::copy(frictions.begin(), frictions.end(), pair->friction);
}

void add_object(mjSpec& spec, const SolidObject& solid, const WorldOptions& options) {
  mjsBody& body = add_object_body(spec, solid.object);
  int number = 0;
  for (const geometry::TriangleMesh& part : solid.parts) {
    mjsGeom& geom = add_solid(spec, body, fmt::format("{}{}", kPart, number++), part);
    set_friction(geom, options.hand_friction);
    set_bits(geom, kPartBits);
  }
  if (!options.exact_tips) return;
  mjsGeom& surface = add_solid(spec, body, kSurface, solid.object.mesh);
  set_friction(surface, options.hand_friction);
  set_bits(surface, kSurfaceBits);
  for (int share = 0; share < kRestingGeoms; ++share) {
    add_resting_geom(spec, body, share, options.table_friction);
  }
}

/// A box, which the robot does not know of.
void add_second_object(mjSpec& spec, double friction) {
  mjsBody* body = mjs_addBody(mjs_findBody(&spec, "world"), nullptr);
  set_name(body->element, kSecond);
  mjs_addFreeJoint(body);
  mjsGeom* geom = mjs_addGeom(body, nullptr);
  set_name(geom->element, kSecond);
  geom->type = mjGEOM_BOX;
  geom->mass = kSecondMass;
  Eigen::Vector3d::Map(geom->size) = kSecondHalf;
  geom->solref[0] = kContactTime;
  std::copy(kObjectImpedance.begin(), kObjectImpedance.end(), geom->solimp);
  set_friction(*geom, friction);
  set_bits(*geom, kSolidBits);
}

/// Names of the joints and actuators that carry the hand.
struct Carrier {
  std::vector<std::string> joints, actuators;
};

Carrier carrier(const hand::ArmDescription* arm) {
  Carrier names;
  if (!arm) {
    for (const MountAxis& axis : kMountAxes) {
      names.joints.emplace_back(axis.name);
      names.actuators.emplace_back(axis.name);
    }
    return names;
  }
  for (const hand::ArmJoint& joint : arm->joints) names.joints.push_back(kArmPrefix + joint.name);
  for (const std::string& name : arm->file.actuators) names.actuators.push_back(kArmPrefix + name);
  return names;
}

void locate(const hand::Description& hand, const hand::ArmDescription* arm, Scene& scene) {
  const mjModel& m = *scene.model;
  scene.root = find_id(m, mjOBJ_BODY, hand.file.root);
  scene.links = links_of_bodies(m, scene.root);
  for (const hand::Joint& joint : hand.joints) {
    scene.joint_positions.push_back(
        m.jnt_qposadr[find_id(m, mjOBJ_JOINT, file_joint(hand, joint.name))]);
  }
  for (const hand::Actuator& actuator : hand.actuators) {
    scene.actuators.push_back(find_id(m, mjOBJ_ACTUATOR, file_actuator(hand, actuator.name)));
  }
  const Carrier names = carrier(arm);
  for (std::size_t i = 0; i < names.joints.size(); ++i) {
    scene.mount_positions.push_back(m.jnt_qposadr[find_id(m, mjOBJ_JOINT, names.joints[i])]);
    scene.base_actuators.push_back(find_id(m, mjOBJ_ACTUATOR, names.actuators[i]));
  }
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    scene.tips.push_back(find_id(m, mjOBJ_GEOM, tip_geom(hand, finger)));
  }
  scene.table = find_id(m, mjOBJ_GEOM, kTable);
  for (int geom = 0; geom < m.ngeom; ++geom) {
    const char* name = mj_id2name(&m, mjOBJ_GEOM, geom);
    if (name && std::string_view(name).starts_with(kFixture)) scene.fixture.push_back(geom);
  }
  scene.object = find_id(m, mjOBJ_BODY, kObject);
  scene.object_position = m.jnt_qposadr[m.body_jntadr[scene.object]];
  scene.second = mj_name2id(&m, mjOBJ_GEOM, kSecond);
  if (scene.second < 0) return;
  scene.second_position = m.jnt_qposadr[m.body_jntadr[m.geom_bodyid[scene.second]]];
}

std::array<int, kRestingGeoms> resting_geoms(const mjModel& model) {
  std::array<int, kRestingGeoms> geoms{};
  for (int share = 0; share < kRestingGeoms; ++share) {
    geoms[static_cast<std::size_t>(share)] = find_id(model, mjOBJ_GEOM, resting_geom(share));
  }
  return geoms;
}

void use_tip_hulls(const hand::Description& hand, Scene& scene) {
  for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
    const auto& hull = hand.fingers[finger].hull;
    if (!hull) continue;
    scene.tip_hulls.push_back(
        std::make_unique<const geometry::RoundedHull>(hull->core, hull->radius));
    use_tip_hull(*scene.model, scene.tips[finger], *scene.tip_hulls.back());
  }
}

}  // namespace

bool Scene::is_sensed(int geom) const {
  return stands_fast(geom) || geom == second || model->geom_bodyid[geom] == object;
}

bool Scene::stands_fast(int geom) const {
  return geom == table || std::find(fixture.begin(), fixture.end(), geom) != fixture.end();
}

Scene compose_scene(const hand::Description& hand, const SolidObject& solid,
                    const geometry::CapsuleCollider& surface, const WorldOptions& options,
                    const Surroundings& surroundings) {
  check(options);
  const Eigen::Isometry3d T_world_table(surroundings.R_world_table);
  const SpecHandle hand_spec = parse_hand(hand);
  prepare_hand(*hand_spec, hand, options);
  const hand::ArmDescription* const arm = surroundings.arm;
  if (!arm) add_mount(*hand_spec, hand);
  const SpecHandle carried = arm ? arm_with_hand(*arm, hand, *hand_spec) : SpecHandle();
  mjSpec* const spec = arm ? carried.get() : hand_spec.get();
  set_solver(*spec, options);
  const Eigen::Vector3d up = surroundings.R_world_table.col(2);
  Eigen::Vector3d::Map(spec->option.gravity) = spec->option.gravity[2] * up;
  add_table(*spec, options.table_friction, options.exact_tips, T_world_table);
  add_fixture(*spec, surroundings.fixture, options.table_friction, T_world_table);
  add_object(*spec, solid, options);
  if (options.second_object) add_second_object(*spec, options.hand_friction);
  Scene scene{.model = compile(*spec), .T_world_table = T_world_table};
  locate(hand, arm, scene);
  if (options.exact_tips) {
    const int geom = find_id(*scene.model, mjOBJ_GEOM, kSurface);
    use_exact_surface(*scene.model, geom, surface);
    use_hull_vertices(*scene.model, resting_geoms(*scene.model));
    use_tip_hulls(hand, scene);
  }
  return scene;
}

}  // namespace palpate::simulation
