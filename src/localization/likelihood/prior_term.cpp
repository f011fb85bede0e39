// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/prior_term.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::localization {

PriorTerm::PriorTerm(std::shared_ptr<const PoseMixture> mixture, double floor)
    : mixture_(std::move(mixture)),
      floor_(floor),
      log_highest_(std::log(mixture_->highest() + floor)) {}

float PriorTerm::energy(const SearchPose& pose, float) const {
  const double density = mixture_->relative_density(pose) + floor_;
  return std::max(0.0F, static_cast<float>(log_highest_ - std::log(density)));
}

void PriorTerm::linearize(const SearchPose& pose, NormalEquations& equations) const {
  mixture_->linearize(pose, floor_, equations);
}

}  // namespace palpate::localization
