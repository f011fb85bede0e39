// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "evidence_term.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// Density (per m and sr) of a true contact's distance and normal at its peak, the contact lying
/// anywhere on the surface (per m^2).
double peak_contact_density(double area, double point_sigma, double normal_sigma);

/// Contacts (p, n) with the surface, each with its own noise, some share of them false.
///
/// With y = R'(p + d n - t), a = phi(y) - d and m = R grad phi: q = a^2 / 2 sp^2 + (1 - n.m) / sn^2
/// (Gaussian distance, von Mises-Fisher normal), E = ln[(1 + A) / (1 + A e^-q)], where
/// A = (1 - eps) / eps p_true(q = 0) / p_false, a false contact being uniform over a litre and all
/// directions. `scale` multiplies the noise.
class ContactTerm : public EvidenceTerm {
 public:
  ContactTerm(const ObjectModel& model, const Evidence& evidence, double offset, double scale);

  float energy(const SearchPose& pose, float bound) const override;

  /// Residuals [a / sp; (m - n) / sn] of every contact, weighted by the probability that it is a
  /// true one: A e^-q / (1 + A e^-q).
  void linearize(const SearchPose& pose, NormalEquations& equations) const override;

  float contact_energy(std::size_t contact, const SearchPose& pose) const;

  /// Contacts that at this pose are more likely false than true.
  int unexplained(const SearchPose& pose) const;

  /// The energy of a pose that explains no contact.
  float energy_if_false() const;

  std::size_t size() const { return contacts_.size(); }

 private:
  struct Datum {
    Eigen::Vector3f raised;  // the contact's point moved out along its normal
    Eigen::Vector3f n;
    float half_point_precision, normal_precision;
    float odds, cap;  // A, ln(1 + A)
  };
  float misfit(const Datum& contact, const SearchPose& pose) const;
  void linearize(const Datum& contact, const SearchPose& pose, NormalEquations& equations) const;

  const geometry::DistanceField& field_;
  float offset_;
  std::vector<Datum> contacts_;
};

}  // namespace palpate::localization
