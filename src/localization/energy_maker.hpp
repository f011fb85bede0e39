// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "evidence_term.hpp"
#include "free_space_term.hpp"
#include "palpate/localization/localizer.hpp"
#include "pose_mixture.hpp"

namespace palpate::localization {

/// Builds the sum of the terms that the evidence calls for, at any noise scale.
class EnergyMaker {
 public:
  EnergyMaker(const ObjectModel& model, const Evidence& evidence, double contact_offset);

  Energy operator()(double scale) const;

 private:
  const ObjectModel& model_;
  const Evidence& evidence_;
  double contact_offset_;
  std::shared_ptr<const PoseMixture> prior_;
  std::shared_ptr<const FreeSpaceTerm::Balls> balls_;
};

}  // namespace palpate::localization
