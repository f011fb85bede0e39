// SPDX-License-Identifier: Apache-2.0
#include "simulation/contact/exact_contact.hpp"

#include <algorithm>
#include <cstdint>
#include <mutex>

namespace palpate::simulation {
namespace {

mjfCollision builtin_collision = nullptr;       // the simulator's own function
mjfCollision builtin_mesh_collision = nullptr;  // that of two meshes

constexpr int kContactsOfATip = 4;

// User data are numbers. An address fits into a double exactly: it has fewer than 53 bits.
mjtNum to_user_data(const void* address) {
  return static_cast<mjtNum>(reinterpret_cast<std::uintptr_t>(address));
}

template <class Thing>
const Thing* user_data(const mjModel& model, int geom, int index) {
  if (model.nuser_geom <= index) return nullptr;
  const mjtNum number = model.geom_user[geom * model.nuser_geom + index];
  return reinterpret_cast<const Thing*>(static_cast<std::uintptr_t>(number));
}

const geometry::CapsuleCollider* collider_of(const mjModel& model, int geom) {
  return user_data<geometry::CapsuleCollider>(model, geom, kExactContactUserData - 1);
}

geometry::Capsule capsule_in(const mjModel& model, const mjData& data, int geom,
                             const Eigen::Isometry3d& T_world_mesh) {
  const Eigen::Vector3d half =
      rotation3(data.geom_xmat + 9 * geom).col(2) * model.geom_size[3 * geom + 1];
  const Eigen::Vector3d center = vector3(data.geom_xpos + 3 * geom);
  const Eigen::Isometry3d T_mesh_world = T_world_mesh.inverse();
  return {T_mesh_world * Eigen::Vector3d(center - half),
          T_mesh_world * Eigen::Vector3d(center + half), model.geom_size[3 * geom]};
}

mjPreContact to_solver(const geometry::CapsuleContact& contact,
                       const Eigen::Isometry3d& T_world_mesh) {
  mjPreContact result{};
  result.dist = contact.distance;
  const Eigen::Vector3d middle = contact.point + 0.5 * contact.distance * contact.normal;
  Eigen::Vector3d::Map(result.pos) = T_world_mesh * middle;
  Eigen::Vector3d::Map(result.normal) = -(T_world_mesh.linear() * contact.normal);
  return result;
}

/// The simulator's interface: contacts of a capsule with a mesh, normals from the first to the
/// second.
int meet_surface(const mjModel* model, mjData* data, mjPreContact* contacts, int capsule, int mesh,
                 mjtNum margin) noexcept {
  const geometry::CapsuleCollider* collider = collider_of(*model, mesh);
  if (!collider) return builtin_collision(model, data, contacts, capsule, mesh, margin);
  const Eigen::Isometry3d T_world_mesh = body_pose(*data, model->geom_bodyid[mesh]);
  // The buffer holds no more than this for the pair.
  const int room = mj_maxContact(model, capsule, mesh, -1);
  const auto found =
      collider->contacts(capsule_in(*model, *data, capsule, T_world_mesh), margin, room);
  std::transform(found.begin(), found.end(), contacts,
                 [&](const auto& contact) { return to_solver(contact, T_world_mesh); });
  return static_cast<int>(found.size());
}

/// The simulator's interface: contacts of a fingertip's hull with a mesh, normals from the first to
/// the second.
int meet_tip_hull(const mjModel* model, mjData* data, mjPreContact* contacts, int first, int second,
                  mjtNum margin) noexcept {
  const bool tip_first = tip_hull_of(*model, first) != nullptr;
  const int tip = tip_first ? first : second, mesh = tip_first ? second : first;
  const geometry::RoundedHull* hull = tip_hull_of(*model, tip);
  const geometry::CapsuleCollider* collider = collider_of(*model, mesh);
  if (!hull || !collider)
    return builtin_mesh_collision(model, data, contacts, first, second, margin);
  const Eigen::Isometry3d T_world_mesh = body_pose(*data, model->geom_bodyid[mesh]);
  const Eigen::Isometry3d T_mesh_hull =
      T_world_mesh.inverse() * body_pose(*data, model->geom_bodyid[tip]);
  const int room = std::min(kContactsOfATip, mj_maxContact(model, first, second, -1));
  const auto found = collider->contacts(*hull, T_mesh_hull, margin, room);
  std::transform(found.begin(), found.end(), contacts, [&](const auto& contact) {
    mjPreContact result = to_solver(contact, T_world_mesh);
    if (!tip_first) mju_scl3(result.normal, result.normal, -1);
    return result;
  });
  return static_cast<int>(found.size());
}

}  // namespace

void use_tip_hull(mjModel& model, int geom, const geometry::RoundedHull& hull) {
  static std::once_flag installed;
  std::call_once(installed, [] {
    builtin_mesh_collision = mjCOLLISIONFUNC[mjGEOM_MESH][mjGEOM_MESH];
    mjCOLLISIONFUNC[mjGEOM_MESH][mjGEOM_MESH] = meet_tip_hull;
  });
  model.geom_user[geom * model.nuser_geom + kTipHullUserData] = to_user_data(&hull);
}

const geometry::RoundedHull* tip_hull_of(const mjModel& model, int geom) {
  return user_data<geometry::RoundedHull>(model, geom, kTipHullUserData);
}

void use_exact_surface(mjModel& model, int geom, const geometry::CapsuleCollider& collider) {
  static std::once_flag installed;
  std::call_once(installed, [] {
    builtin_collision = mjCOLLISIONFUNC[mjGEOM_CAPSULE][mjGEOM_MESH];
    mjCOLLISIONFUNC[mjGEOM_CAPSULE][mjGEOM_MESH] = meet_surface;
  });
  model.geom_user[geom * model.nuser_geom] = to_user_data(&collider);
}

}  // namespace palpate::simulation
