// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "localization/likelihood/evidence_term.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// Pushes and weight turn the object no more than what is not known of them may.
///
/// With c the centre of mass, m(c) = sum_k p_k x f_k + c x w is their moment about the pushes'
/// middle, C its covariance from the errors of points and forces and the twist of soft fingertips:
/// E = -ln((1 - d) e^-q + d e^(-q/D) / D^(3/2)), q = m' C^-1 m / 2, d the prior of other support, D
/// = 100.
class BalanceTerm : public EvidenceTerm {
 public:
  BalanceTerm(const geometry::ObjectModel& model, const ForceBalance& balance, double scale);

  float energy(const SearchPose& pose, float bound) const override;
  void linearize(const SearchPose& pose, NormalEquations& equations) const override;

 private:
  Eigen::Vector3f whitened_moment(const SearchPose& pose) const;
  struct Exponents {
    float held, other;  ///< ln of both parts of e^-E: nothing else holds the object, or something
  };
  Exponents exponents(float q) const;

  Eigen::Vector3f center_;  // of mass, in the object's frame
  Eigen::Vector3f middle_;  // of the pushes
  Eigen::Vector3f moment_;  // of the pushes about it
  Eigen::Vector3f weight_;
  Eigen::Matrix3f whitening_;  // W'W is the inverse of C
  float other_support_prior_;
};

}  // namespace palpate::localization
