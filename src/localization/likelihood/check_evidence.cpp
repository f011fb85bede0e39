// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/check_evidence.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numeric>

#include "localization/likelihood/pose_mixture.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/plausible.hpp"

namespace palpate::localization {
namespace {

constexpr double kNormalTolerance = 1e-3;
constexpr double kLargestExtent = 20;  // of the contacts, in the object's sizes
constexpr double kWeightTolerance = 1e-6;
constexpr double kAsymmetry = 1e-9;  // of a covariance, relative to its largest entry

void check_positive(const std::string& what, double value) {
  if (!(std::isfinite(value) && value > 0)) {
    throw BadInput(fmt::format("{} is {}, not positive", what, value));
  }
}

void check_area(const Evidence& evidence) {
  if (evidence.contact_area) check_positive("contact_area", *evidence.contact_area);
}

void check_not_negative(const std::string& what, double value) {
  if (!(std::isfinite(value) && value >= 0)) {
    throw BadInput(fmt::format("{} is {}, not finite and >= 0", what, value));
  }
}

void check_finite(const std::string& what, const Eigen::Vector3d& v) {
  if (!v.allFinite()) {
    throw BadInput(fmt::format("{} is ({}, {}, {}), not finite", what, v.x(), v.y(), v.z()));
  }
}

void check_contact(const tactile::Contact& contact, std::size_t index) {
  const std::string name = fmt::format("contact {}: ", index);
  check_finite(name + "point", contact.p);
  check_plausible(contact.p, kMaxLength, name + "a coordinate in m");
  check_finite(name + "normal", contact.n);
  if (contact.has_normal() && !(std::abs(contact.n.norm() - 1) < kNormalTolerance)) {
    throw BadInput(fmt::format("{}normal has length {}, not 1", name, contact.n.norm()));
  }
  check_positive(name + "point_sigma", contact.point_sigma);
  if (contact.has_normal()) check_positive(name + "normal_sigma", contact.normal_sigma);
}

/// Of lengths beyond what is plausible the squares would not fit into the search's numbers.
void check_sphere(const FreeSphere& sphere, std::size_t index) {
  const std::string name = fmt::format("free sphere {}: ", index);
  check_finite(name + "center", sphere.center);
  check_plausible(sphere.center, kMaxLength, name + "a coordinate in m");
  check_not_negative(name + "radius", sphere.radius);
  plausible(sphere.radius, 0, kMaxLength, name + "its radius in m");
}

void check_stable_pose_weights(const std::vector<double>& weights, std::size_t stable_poses) {
  if (stable_poses == 0) throw BadInput("table: the object has 0 stable poses");
  if (weights.empty()) return;
  if (weights.size() != stable_poses) {
    throw BadInput(fmt::format("table: {} stable pose weights for {} stable poses", weights.size(),
                               stable_poses));
  }
  for (const double weight : weights) check_not_negative("table: a stable pose weight", weight);
  check_positive("table: the sum of the stable pose weights",
                 std::accumulate(weights.begin(), weights.end(), 0.0));
}

void check_table(const TableSupport& table, std::size_t stable_poses) {
  if (!table.T_frame_table.matrix().allFinite()) {
    throw BadInput("table: T_frame_table holds a value that is not finite");
  }
  check_stable_pose_weights(table.stable_pose_weights, stable_poses);
  check_positive("table: tilt_sigma", table.tilt_sigma);
  check_positive("table: height_sigma", table.height_sigma);
  check_positive("table: edge_sigma", table.edge_sigma);
  check_not_negative("table: half_width", table.half_width);
  check_not_negative("table: surface_sigma", table.surface_sigma);
  check_not_negative("table: centroid_sigma", table.centroid_sigma);
}

void check_covariance(const std::string& name, const Matrix6d& covariance) {
  if (!covariance.allFinite()) throw BadInput(name + "covariance holds a value that is not finite");
  const double skewness = (covariance - covariance.transpose()).cwiseAbs().maxCoeff();
  if (skewness > kAsymmetry * covariance.cwiseAbs().maxCoeff()) {
    throw BadInput(fmt::format("{}covariance is not symmetric, by {}", name, skewness));
  }
  if (covariance.llt().info() != Eigen::Success) {
    const Eigen::SelfAdjointEigenSolver<Matrix6d> spectrum(covariance, Eigen::EigenvaluesOnly);
    throw BadInput(fmt::format("{}covariance is not positive definite, least eigenvalue {}", name,
                               spectrum.eigenvalues()[0]));
  }
}

void check_component(const PosePrior::Component& component, std::size_t index) {
  const std::string name = fmt::format("prior: component {}: ", index);
  const Eigen::Matrix3d R = component.T_frame_object.linear();
  const double distortion = (R * R.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(distortion < kNormalTolerance && R.determinant() > 0)) {
    throw BadInput(fmt::format("{}its rotation is off a rotation by {}", name, distortion));
  }
  check_finite(name + "translation", component.T_frame_object.translation());
  check_not_negative(name + "weight", component.weight);
  check_covariance(name, component.covariance);
}

void check_prior(const PosePrior& prior) {
  for (std::size_t i = 0; i < prior.components.size(); ++i) check_component(prior.components[i], i);
  const double total = total_weight(prior);
  if (!(total > 0 && total <= 1 + kWeightTolerance)) {
    throw BadInput(fmt::format("prior: the sum of {} weights is {}, not > 0 and <= 1",
                               prior.components.size(), total));
  }
  if (!(prior.floor > 0 && prior.floor < 1)) {
    throw BadInput(fmt::format("prior: floor is {}, not between 0 and 1", prior.floor));
  }
}

void check_offsets(const Evidence& evidence) {
  std::vector<bool> taken(evidence.contacts.size());
  for (std::size_t i = 0; i < evidence.offsets.size(); ++i) {
    const std::string name = fmt::format("offset {}: ", i);
    check_positive(name + "sigma", evidence.offsets[i].sigma);
    for (const auto& member : evidence.offsets[i].members) {
      if (member.contact >= taken.size()) {
        throw BadInput(
            fmt::format("{}contact {} of {} contacts", name, member.contact, taken.size()));
      }
      if (taken[member.contact]) {
        throw BadInput(fmt::format("{}contact {} is in another one, too", name, member.contact));
      }
      taken[member.contact] = true;
      if (evidence.contacts[member.contact].group >= 0) {
        throw BadInput(fmt::format("{}contact {} is one of group {}, which can share no offset",
                                   name, member.contact, evidence.contacts[member.contact].group));
      }
      const Eigen::Matrix3d& R = member.R_frame_offset;
      const double distortion = (R * R.transpose() - Eigen::Matrix3d::Identity()).norm();
      if (!(distortion < kNormalTolerance)) {
        throw BadInput(fmt::format("{}its rotation is off a rotation by {}", name, distortion));
      }
    }
  }
}

void check_balance(const ForceBalance& balance) {
  if (balance.pushes.empty()) throw BadInput("balance: 0 pushes hold the object");
  for (std::size_t k = 0; k < balance.pushes.size(); ++k) {
    const std::string name = fmt::format("balance: push {}: ", k);
    check_finite(name + "point", balance.pushes[k].p);
    check_finite(name + "normal", balance.pushes[k].n);
    check_finite(name + "force", balance.pushes[k].f);
    if (std::abs(balance.pushes[k].n.norm() - 1) > kNormalTolerance) {
      throw BadInput(
          fmt::format("{}normal has length {}, not 1", name, balance.pushes[k].n.norm()));
    }
  }
  check_finite("balance: weight", balance.weight);
  check_positive("balance: the weight", balance.weight.norm());
  check_positive("balance: point_sigma", balance.point_sigma);
  check_positive("balance: force_sigma", balance.force_sigma);
  check_not_negative("balance: torsional_friction_radius", balance.torsional_friction_radius);
  if (!(balance.other_support_prior > 0 && balance.other_support_prior < 1)) {
    throw BadInput(fmt::format("balance: other_support_prior is {}, not between 0 and 1",
                               balance.other_support_prior));
  }
}

void check_plane(const PlaneContact& plane, std::size_t index) {
  const std::string name = fmt::format("plane {}: ", index);
  check_finite(name + "normal", plane.normal);
  if (!(std::abs(plane.normal.norm() - 1) < kNormalTolerance)) {
    throw BadInput(fmt::format("{}normal has length {}, not 1", name, plane.normal.norm()));
  }
  plausible(plane.height, -kMaxLength, kMaxLength, name + "height in m");
  check_positive(name + "sigma", plane.sigma);
}

void check_probability(const std::string& name, double value) {
  if (value >= 0 && value < 1) return;
  throw BadInput(fmt::format("{} is {}, not from 0 to 1", name, value));
}

/// Contacts over a space that the object is tiny in are most likely in another unit.
void check_extent(const std::vector<tactile::Contact>& contacts,
                  const geometry::TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& contact : contacts) box.extend(contact.p);
  if (contacts.empty()) return;
  const double extent = box.diagonal().norm(), object = geometry::bounds(mesh).diagonal().norm();
  if (extent <= kLargestExtent * object) return;
  throw BadInput(
      fmt::format("the contacts spread over {:.3g} m, but the object measures {:.3g} m; are they "
                  "in millimetres?",
                  extent, object));
}

}  // namespace

void check_evidence(const geometry::ObjectModel& model, const Evidence& evidence) {
  for (std::size_t k = 0; k < evidence.contacts.size(); ++k) check_contact(evidence.contacts[k], k);
  check_extent(evidence.contacts, model.object().mesh);
  check_area(evidence);
  check_offsets(evidence);
  check_probability("noise_scale_prior", evidence.noise_scale_prior);
  check_probability("size_prior", evidence.size_prior);
  for (std::size_t j = 0; j < evidence.free_space.size(); ++j) {
    check_sphere(evidence.free_space[j], j);
  }
  check_not_negative("surface_sigma", evidence.surface_sigma);
  plausible(evidence.surface_sigma, 0, kMaxRadius, "surface_sigma in m");
  check_positive("penetration_sigma", evidence.penetration_sigma);
  const double share = evidence.false_contact_share;
  if (!(share > 0 && share < 1)) {
    throw BadInput(fmt::format("false_contact_share is {}, not between 0 and 1", share));
  }
  for (std::size_t i = 0; i < evidence.planes.size(); ++i) check_plane(evidence.planes[i], i);
  if (evidence.balance) check_balance(*evidence.balance);
  if (evidence.table) check_table(*evidence.table, model.object().stable_poses.size());
  if (evidence.prior) check_prior(*evidence.prior);
}

}  // namespace palpate::localization
