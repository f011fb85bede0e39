// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/taxel_contact.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace palpate::grasping {
namespace {

constexpr double kMinForce = 1e-6;  // N

/// The larger root of |a + x d|^2 = r^2.
std::optional<double> far_crossing(const Eigen::VectorXd& a, const Eigen::VectorXd& d, double r) {
  const double dd = d.squaredNorm(), ad = a.dot(d);
  const double inside = ad * ad - dd * (a.squaredNorm() - r * r);
  if (dd <= 0 || inside < 0) return std::nullopt;
  return (std::sqrt(inside) - ad) / dd;
}

/// Where a line leaves the skin: the half ball, or the cylinder behind it, which ends at the back.
std::optional<Eigen::Vector3d> leaves_skin(const Eigen::Vector3d& p, const Eigen::Vector3d& d,
                                           const tactile::SkinOptions& skin) {
  const double radius = skin.radius;
  if (const auto x = far_crossing(p, d, radius); x && (p + *x * d).x() >= 0) return p + *x * d;
  const auto x = far_crossing(p.tail<2>(), d.tail<2>(), radius);
  if (!x) return std::nullopt;
  const Eigen::Vector3d end = p + *x * d;
  if (end.x() > 0 || end.x() < -skin.length) return std::nullopt;
  return end;
}

}  // namespace

TaxelGrasp taxel_grasp(const tactile::BiotacSkin& skin, const tactile::SkinState& state) {
  TaxelGrasp grasp;
  std::vector<double> wrenches;
  for (Eigen::Index i = 0; i < tactile::kTaxels; ++i) {
    if (state.pressure[i] <= 0) continue;
    const Eigen::Vector3d outward = skin.normals().col(i);
    const Eigen::Vector3d force =
        skin.areas()[i] * (state.pressure[i] * outward + state.shear.col(i));
    grasping::GraspContact contact;
    contact.T_mount_contact = grasping::contact_frame(skin.points().col(i), -outward);
    contact.model = grasping::ContactModel::hard_finger;
    const Eigen::Vector3d f = contact.T_mount_contact.linear().transpose() * force;
    wrenches.insert(wrenches.end(), {0, 0, 0, f.x(), f.y(), f.z()});
    grasp.contacts.push_back(contact);
  }
  grasp.wrenches = Eigen::Map<const Eigen::VectorXd>(wrenches.data(),
                                                     static_cast<Eigen::Index>(wrenches.size()));
  return grasp;
}

std::optional<hand::TipContact> contact_of_taxels(const tactile::BiotacSkin& skin,
                                                  const tactile::SkinState& state) {
  const TaxelGrasp grasp = taxel_grasp(skin, state);
  if (grasp.contacts.empty()) return std::nullopt;
  const Eigen::MatrixXd G = grasping::grasp_matrix(grasp.contacts, Eigen::Vector3d::Zero());
  const Vector6d wrench = grasping::object_wrench(G, grasp.wrenches);
  const Eigen::Vector3d m = wrench.head<3>(), f = wrench.tail<3>();
  if (f.norm() < kMinForce) return std::nullopt;
  const Eigen::Vector3d on_axis = f.cross(m) / f.squaredNorm();
  const auto p = leaves_skin(on_axis, f.normalized(), skin.options());
  if (!p) return std::nullopt;
  return hand::TipContact{.p = *p, .n = -skin.normal_at(*p), .f = f};
}

}  // namespace palpate::grasping
