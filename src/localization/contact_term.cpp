// SPDX-License-Identifier: Apache-2.0
#include "contact_term.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

constexpr double kFalseVolume = 1e-3;      // m^3 in which a false contact may lie
constexpr double kWidestNormal = 0.6;      // rad; a wider normal says nothing
constexpr float kShortestGradient = 0.3F;  // interpolated across a medial sheet: no direction
constexpr float kCurvatureStep = 0.001F;   // m, over which the gradient's change is measured
constexpr double kLeastTrust = 0.02;       // of a contact off the surface: it still draws the pose
constexpr float kHopeless = 30;            // misfit whose likelihood rounds to that of a false one

double true_to_false_odds(double false_share, double area, double sp, double sn) {
  const double false_density = 1 / (kFalseVolume * 4 * std::numbers::pi);
  return (1 - false_share) / false_share * peak_contact_density(area, sp, sn) / false_density;
}

}  // namespace

double peak_contact_density(double area, double point_sigma, double normal_sigma) {
  using std::numbers::pi;
  const double sn = std::min(normal_sigma, kWidestNormal);
  const double point_density = 1 / (area * std::sqrt(2 * pi) * point_sigma);
  const double normal_density = 1 / (2 * pi * sn * sn * (1 - std::exp(-2 / (sn * sn))));
  return point_density * normal_density;
}

ContactTerm::ContactTerm(const ObjectModel& model, const Evidence& evidence, double offset,
                         double scale)
    : field_(model.field()), offset_(static_cast<float>(offset)) {
  for (const touch::Contact& contact : evidence.contacts) {
    const double sp = scale * contact.point_sigma;
    const double sn = std::min(scale * contact.normal_sigma, kWidestNormal);
    const double odds = true_to_false_odds(evidence.false_contact_share, model.area(), sp, sn);
    const Eigen::Vector3d n = contact.n.normalized();
    contacts_.push_back({(contact.p + offset * n).cast<float>(), n.cast<float>(),
                         static_cast<float>(0.5 / (sp * sp)), static_cast<float>(1 / (sn * sn)),
                         static_cast<float>(odds), static_cast<float>(std::log1p(odds))});
  }
}

float ContactTerm::misfit(const Datum& contact, const SearchPose& pose) const {
  const auto sample = field_.at(pose.R.transpose() * (contact.raised - pose.t));
  if (!sample) return kHopeless;
  const float away = sample->distance - offset_;
  const float length = std::max(kShortestGradient, sample->gradient.norm());
  const float aligned = (pose.R.transpose() * contact.n).dot(sample->gradient) / length;
  return away * away * contact.half_point_precision + (1 - aligned) * contact.normal_precision;
}

float ContactTerm::contact_energy(std::size_t k, const SearchPose& pose) const {
  const Datum& contact = contacts_[k];
  const float q = misfit(contact, pose);
  return q < kHopeless ? contact.cap - std::log1p(contact.odds * std::exp(-q)) : contact.cap;
}

void ContactTerm::linearize(const SearchPose& pose, NormalEquations& equations) const {
  for (const Datum& contact : contacts_) linearize(contact, pose, equations);
}

void ContactTerm::linearize(const Datum& contact, const SearchPose& pose,
                            NormalEquations& equations) const {
  const Eigen::Vector3f arm = contact.raised - pose.t;
  const Eigen::Matrix3f to_object = pose.R.transpose();
  const Eigen::Vector3f y = to_object * arm;
  const auto here = field_.at(y);
  if (!here || here->gradient.norm() < kShortestGradient) return;
  const Eigen::Vector3f m = here->gradient.normalized(), n = to_object * contact.n;
  Eigen::Matrix3f curvature = Eigen::Matrix3f::Zero();  // of the distance
  for (int axis = 0; axis < 3; ++axis) {
    const auto beside = field_.at(y + kCurvatureStep * Eigen::Vector3f::Unit(axis));
    if (!beside || beside->gradient.norm() < kShortestGradient) continue;
    curvature.col(axis) = (beside->gradient.normalized() - m) / kCurvatureStep;
  }
  Eigen::Matrix<float, 3, 6> dy;  // of the point in the object's frame by [w; v]
  dy << to_object * skew(arm.cast<double>()).cast<float>(), -to_object;
  const float point_scale = std::sqrt(2 * contact.half_point_precision);
  const float normal_scale = std::sqrt(contact.normal_precision);
  Eigen::Matrix<float, 4, 6> J;
  J.row(0) = point_scale * m.transpose() * dy;
  J.bottomRows<3>() = normal_scale * curvature * dy;
  J.bottomLeftCorner<3, 3>() -=
      normal_scale * to_object * skew(contact.n.cast<double>()).cast<float>();
  Eigen::Vector4f r;
  r << point_scale * (here->distance - offset_), normal_scale * (m - n);
  const double q = 0.5 * static_cast<double>(r.squaredNorm());
  const double odds = static_cast<double>(contact.odds) * std::exp(-q);
  const double weight = std::max(odds / (1 + odds), kLeastTrust / (1 + q));
  equations.add(J.cast<double>(), r.cast<double>(), weight);
}

float ContactTerm::energy(const SearchPose& pose, float bound) const {
  float sum = 0;
  for (std::size_t k = 0; k < contacts_.size() && sum <= bound; ++k) {
    sum += contact_energy(k, pose);
  }
  return sum;
}

float ContactTerm::energy_if_false() const {
  float sum = 0;
  for (const Datum& contact : contacts_) sum += contact.cap;
  return sum;
}

int ContactTerm::unexplained(const SearchPose& pose) const {
  return static_cast<int>(std::count_if(
      contacts_.begin(), contacts_.end(),
      [&](const Datum& contact) { return contact.odds * std::exp(-misfit(contact, pose)) < 1; }));
}

}  // namespace palpate::localization
