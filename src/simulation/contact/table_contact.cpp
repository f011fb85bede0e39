// SPDX-License-Identifier: Apache-2.0
#include "simulation/contact/table_contact.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <span>
#include <vector>

#include "simulation/contact/exact_contact.hpp"

namespace palpate::simulation {
namespace {

constexpr int kContactsOfAGeom = 4;  // the simulator has room for no more between plane and mesh
constexpr int kMaxContacts = kRestingGeoms * kContactsOfAGeom;
constexpr double kTilt = 1e-3;  // rad, by which the body may turn before other vertices bear it

mjfCollision meet_few_vertices = nullptr;  // the simulator's own function

/// Number of the geom among those that share a body's contacts; -1: it is none of them.
int share_of(const mjModel& model, int geom) {
  if (model.nuser_geom <= kHullContactUserData) return -1;
  return static_cast<int>(model.geom_user[geom * model.nuser_geom + kHullContactUserData]) - 1;
}

Eigen::Isometry3d geom_pose(const mjData& data, int geom) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotation3(data.geom_xmat + 9 * geom);
  T.translation() = vector3(data.geom_xpos + 3 * geom);
  return T;
}

/// Numbers of the convex hull's vertices among those of the mesh (mjModel::mesh_graph).
std::span<const int> hull_vertices(const mjModel& model, int mesh) {
  const int* graph = model.mesh_graph + model.mesh_graphadr[mesh];
  const auto count = static_cast<std::size_t>(graph[0]);
  return {graph + 2 + count, count};
}

/// Vertices of the hull less than `margin` above the plane, in the plane's frame.
std::vector<Eigen::Vector3d> low_vertices(const mjModel& model, int geom,
                                          const Eigen::Isometry3d& T_plane_mesh, double margin) {
  const int mesh = model.geom_dataid[geom];
  const float* vertices = model.mesh_vert + 3 * model.mesh_vertadr[mesh];
  std::vector<Eigen::Vector3d> low;
  for (const int v : hull_vertices(model, mesh)) {
    const Eigen::Vector3d p = T_plane_mesh * Eigen::Vector3f::Map(vertices + 3 * v).cast<double>();
    if (p.z() < margin) low.push_back(p);
  }
  return low;
}

/// Those that bear the body when it leans a little towards any of several sides, fixed to the body.
std::vector<Eigen::Vector3d> bearing_vertices(const std::vector<Eigen::Vector3d>& low,
                                              const Eigen::Matrix3d& R_plane_mesh,
                                              int sides = kMaxContacts) {
  const double heading = std::atan2(R_plane_mesh(1, 0), R_plane_mesh(0, 0));
  std::vector<std::size_t> chosen;
  for (int side = 0; side < sides; ++side) {
    const double angle = heading + 2 * std::numbers::pi * side / sides;
    const Eigen::Vector3d down(kTilt * std::cos(angle), kTilt * std::sin(angle), -1);
    const auto lowest =
        std::ranges::max_element(low, {}, [&](const Eigen::Vector3d& p) { return down.dot(p); });
    const auto found = static_cast<std::size_t>(lowest - low.begin());
    if (std::ranges::find(chosen, found) == chosen.end()) chosen.push_back(found);
  }
  std::vector<Eigen::Vector3d> bearing;
  for (const std::size_t i : chosen) bearing.push_back(low[i]);
  return bearing;
}

mjPreContact to_solver(const Eigen::Vector3d& p, const Eigen::Isometry3d& T_world_plane) {
  mjPreContact contact{};
  contact.dist = p.z();
  const Eigen::Vector3d middle(p.x(), p.y(), p.z() / 2);
  Eigen::Vector3d::Map(contact.pos) = T_world_plane * middle;
  Eigen::Vector3d::Map(contact.normal) = T_world_plane.linear().col(2);
  return contact;
}

/// Contacts of a plane with a fingertip: below the lowest corners of its core.
int meet_tip(const mjModel& model, const mjData& data, mjPreContact* contacts, int plane, int tip,
             const geometry::RoundedHull& hull, double margin) {
  const Eigen::Isometry3d T_world_plane = geom_pose(data, plane);
  const Eigen::Isometry3d T_plane_tip =
      T_world_plane.inverse() * body_pose(data, model.geom_bodyid[tip]);
  std::vector<Eigen::Vector3d> low;
  for (const auto& corner : hull.corners()) {
    const Eigen::Vector3d p = T_plane_tip * corner.p - hull.radius() * Eigen::Vector3d::UnitZ();
    if (p.z() < margin) low.push_back(p);
  }
  if (low.size() > kContactsOfAGeom) {
    low = bearing_vertices(low, T_plane_tip.linear(), kContactsOfAGeom);
  }
  std::ranges::transform(low, contacts, [&](const auto& p) { return to_solver(p, T_world_plane); });
  return static_cast<int>(low.size());
}

/// The simulator's interface: contacts of a plane with a mesh, normals from the first to the
/// second.
int meet_hull(const mjModel* model, mjData* data, mjPreContact* contacts, int plane, int mesh,
              mjtNum margin) noexcept {
  if (const auto* hull = tip_hull_of(*model, mesh)) {
    return meet_tip(*model, *data, contacts, plane, mesh, *hull, margin);
  }
  const int share = share_of(*model, mesh);
  if (share < 0) {
    return meet_few_vertices(model, data, contacts, plane, mesh, margin);
  }
  const Eigen::Isometry3d T_world_plane = geom_pose(*data, plane);
  const Eigen::Isometry3d T_plane_mesh = T_world_plane.inverse() * geom_pose(*data, mesh);
  std::vector<Eigen::Vector3d> low = low_vertices(*model, mesh, T_plane_mesh, margin);
  if (low.size() > kMaxContacts) low = bearing_vertices(low, T_plane_mesh.linear());
  const auto first = static_cast<std::size_t>(share * kContactsOfAGeom);
  int count = 0;
  for (std::size_t i = first; i < low.size() && count < kContactsOfAGeom; ++i) {
    contacts[count++] = to_solver(low[i], T_world_plane);
  }
  return count;
}

}  // namespace

void use_hull_vertices(mjModel& model, const std::array<int, kRestingGeoms>& geoms) {
  static std::once_flag installed;
  std::call_once(installed, [] {
    meet_few_vertices = mjCOLLISIONFUNC[mjGEOM_PLANE][mjGEOM_MESH];
    mjCOLLISIONFUNC[mjGEOM_PLANE][mjGEOM_MESH] = meet_hull;
  });
  for (int share = 0; share < kRestingGeoms; ++share) {
    const int geom = geoms[static_cast<std::size_t>(share)];
    model.geom_user[geom * model.nuser_geom + kHullContactUserData] = share + 1;
  }
}

}  // namespace palpate::simulation
