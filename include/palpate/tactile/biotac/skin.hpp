// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>

#include "palpate/hand/hand.hpp"

namespace palpate::tactile {

inline constexpr int kTaxels = 512;

/// Frame of a BioTac ("sensor frame"): x forward out of the fingertip, z from the sensing side into
/// the core, origin at the centre of the tip's half ball.
struct SkinOptions {
  double radius = 0.007;           ///< m, of the half ball and the cylinder behind it
  double length = 0.014;           ///< m, of the cylinder
  double stiffness = 9.4e7;        ///< Pa/m, E'/h of the fluid-filled skin
  double shear_stiffness = 2.5e7;  ///< Pa/m, G/h: (1 - 2 nu) / (2 - 2 nu) of it, nu = 0.316
  double friction = 0.8;           ///< of skin on object
  double crown = 0.057;            ///< m, radius by which pressure falls off around a contact

  template <class Visitor>
  void visit(Visitor&& v) {
    v("radius", radius, 0.001, 0.1, "m, radius of the half ball and of the cylinder behind it");
    v("length", length, 0.0, 0.1, "m, length of the cylinder");
    v("stiffness", stiffness, 1e5, 1e12, "Pa/m, pressure per depth");
    v("shear_stiffness", shear_stiffness, 1e5, 1e12, "Pa/m, shear stress per displacement");
    v("friction", friction, 0.0, 5.0, "friction coefficient of skin and object");
    v("crown", crown, 0.001, 1e3, "m, radius over which the pressure falls off around a contact");
  }
};

/// Signed distance (m) of the object's surface from a point in the sensor frame, negative inside.
using SurfaceDistance = std::function<double(const Eigen::Vector3d&)>;

/// What the skin does under load, taxel by taxel.
struct SkinState {
  Eigen::VectorXd depth = Eigen::VectorXd::Zero(kTaxels);     ///< m, >= 0
  Eigen::VectorXd pressure = Eigen::VectorXd::Zero(kTaxels);  ///< Pa
  /// Shear stress of the skin on the object, Pa.
  Eigen::Matrix3Xd shear = Eigen::Matrix3Xd::Zero(3, kTaxels);
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< sum of the taxels' forces on the object, N
  /// A contact beyond the skin, that no taxel can carry.
  bool off_skin = false;
};

/// Elastic foundation (Winkler) with tangential springs that slip at friction times pressure.
///
/// The solver treats the tip as rigid. The skin yields, until its taxels carry the solver's force:
/// F = sum A_i (p_i n_i + tau_i), p_i = k d_i, d_i = max(0, s - h_i), |tau_i| <= mu p_i, with h_i
/// the object's distance from taxel i plus r_i^2 / (2 crown), r_i from the contact: the core rocks
/// on the skin until the contact is where it presses most. The approach s and the shear
/// displacement u follow exactly from F, for both sums are piecewise linear in them. Only a shear
/// beyond friction is cut.
class BiotacSkin {
 public:
  explicit BiotacSkin(const SkinOptions& options = {});

  [[nodiscard]] const SkinOptions& options() const { return options_; }
  [[nodiscard]] const Eigen::Matrix3Xd& points() const { return points_; }    ///< m
  [[nodiscard]] const Eigen::Matrix3Xd& normals() const { return normals_; }  ///< outward, unit
  [[nodiscard]] const Eigen::VectorXd& areas() const { return areas_; }       ///< m^2

  /// @param contacts  of the solver, in the sensor frame; each loads the taxels nearest to it
  /// @param surface  the object's; without one, the plane through each contact
  /// @throws BadInput for a contact that is not finite
  [[nodiscard]] SkinState press(std::span<const hand::TipContact> contacts,
                                const SurfaceDistance& surface = {}) const;

  /// Nearest point on the undeformed skin's surface (its extension backwards included).
  [[nodiscard]] Eigen::Vector3d on_skin(const Eigen::Vector3d& p) const;
  /// Outward unit normal of the skin at the point of it nearest to p.
  [[nodiscard]] Eigen::Vector3d normal_at(const Eigen::Vector3d& p) const;

 private:
  void load(const hand::TipContact& contact, const std::vector<int>& taxels,
            const SurfaceDistance& surface, SkinState& state) const;

  SkinOptions options_;
  Eigen::Matrix3Xd points_, normals_;
  Eigen::VectorXd areas_;
};

}  // namespace palpate::tactile
