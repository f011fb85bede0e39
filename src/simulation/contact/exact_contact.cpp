// SPDX-License-Identifier: Apache-2.0
#include "simulation/contact/exact_contact.hpp"

#include <algorithm>
#include <cstdint>
#include <mutex>

namespace palpate::simulation {
namespace {

mjfCollision builtin_collision = nullptr;  // the simulator's own function

// User data are numbers. An address fits into a double exactly: it has fewer than 53 bits.
mjtNum to_user_data(const geometry::CapsuleCollider* collider) {
  return static_cast<mjtNum>(reinterpret_cast<std::uintptr_t>(collider));
}

const geometry::CapsuleCollider* collider_of(const mjModel& model, int geom) {
  if (model.nuser_geom < kExactContactUserData) return nullptr;
  const mjtNum number = model.geom_user[geom * model.nuser_geom];
  return reinterpret_cast<const geometry::CapsuleCollider*>(static_cast<std::uintptr_t>(number));
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
  const int body = model->geom_bodyid[mesh];
  Eigen::Isometry3d T_world_mesh = Eigen::Isometry3d::Identity();
  T_world_mesh.linear() = rotation3(data->xmat + 9 * body);
  T_world_mesh.translation() = vector3(data->xpos + 3 * body);
  // The buffer holds no more than this for the pair.
  const int room = mj_maxContact(model, capsule, mesh, -1);
  const auto found =
      collider->contacts(capsule_in(*model, *data, capsule, T_world_mesh), margin, room);
  std::transform(found.begin(), found.end(), contacts,
                 [&](const auto& contact) { return to_solver(contact, T_world_mesh); });
  return static_cast<int>(found.size());
}

}  // namespace

void use_exact_surface(mjModel& model, int geom, const geometry::CapsuleCollider& collider) {
  static std::once_flag installed;
  std::call_once(installed, [] {
    builtin_collision = mjCOLLISIONFUNC[mjGEOM_CAPSULE][mjGEOM_MESH];
    mjCOLLISIONFUNC[mjGEOM_CAPSULE][mjGEOM_MESH] = meet_surface;
  });
  model.geom_user[geom * model.nuser_geom] = to_user_data(&collider);
}

}  // namespace palpate::simulation
