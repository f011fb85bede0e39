// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "localization/likelihood/evidence_term.hpp"
#include "localization/likelihood/free_space_term.hpp"
#include "localization/likelihood/pose_mixture.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// Builds the sum of the terms that the evidence calls for, at any noise scale.
class EnergyMaker {
 public:
  EnergyMaker(const geometry::ObjectModel& model, const Evidence& evidence,
              const LocalizerOptions& options);

  Energy operator()(double scale) const;

  /// Noise scale at which the search starts: the usual one, or greater for exact contacts.
  double first_scale() const;

 private:
  Evidence widened(double scale) const;

  const geometry::ObjectModel& model_;
  const Evidence& evidence_;
  double contact_offset_;
  double default_first_scale_, first_point_sigma_;
  std::shared_ptr<const PoseMixture> prior_;
  std::shared_ptr<const FreeSpaceTerm::Balls> balls_;
};

}  // namespace palpate::localization
