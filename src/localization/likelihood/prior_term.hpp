// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "localization/likelihood/evidence_term.hpp"
#include "localization/likelihood/pose_mixture.hpp"

namespace palpate::localization {

/// What was known of the pose before: E = -ln(sum_i w_i N_i / max_i w_i N_i(0) + floor), raised by
/// a constant so that it is never negative. The noise scale does not widen it.
class PriorTerm : public EvidenceTerm {
 public:
  PriorTerm(std::shared_ptr<const PoseMixture> mixture, double floor);

  float energy(const SearchPose& pose, float bound) const override;
  void linearize(const SearchPose& pose, NormalEquations& equations) const override;

  /// ln of what scales e^-E to the density of the prior (per rad^3 m^3), its floor aside.
  double log_peak() const { return log_highest_ + mixture_->log_peak(); }

 private:
  std::shared_ptr<const PoseMixture> mixture_;
  double floor_;
  double log_highest_;
};

}  // namespace palpate::localization
